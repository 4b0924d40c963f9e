"""The hand-written C loop, compiled on this machine when it is asked for."""

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FLAGS = ("-O3", "-march=native")
Signals = NDArray[np.float64]


class NoCompilerError(RuntimeError):
    """There is no C compiler, or it cannot compile the loop."""


def compiler() -> str:
    """Path of ``$CC`` or ``cc``; NoCompilerError where there is none."""
    name = os.environ.get("CC", "cc")
    found = shutil.which(name)
    if found is None:
        raise NoCompilerError(f"no C compiler: {name} is not on the PATH")
    return found


def c_loop(reference: Signals, constants: Signals) -> Callable[[], tuple[Signals, Signals]]:
    """The loop on ``reference`` (samples, 2) [rad]; each call returns measured [rad] and command [N m].

    ``constants`` (12,) are those of the struct in ``c_drive_loop.c``. Raises NoCompilerError.
    """
    function = _load(resources.files(__package__).joinpath("c_drive_loop.c").read_text())
    reference = np.ascontiguousarray(reference)
    samples = len(reference)

    def run() -> tuple[Signals, Signals]:
        measured, command = np.empty((samples, 2)), np.empty((samples, 2))
        function(samples, *(a.ctypes.data for a in (reference, constants, measured, command)))
        return measured, command

    return run


def _load(source: str) -> Any:
    with tempfile.TemporaryDirectory(prefix="gapscope-bench-") as folder:
        file, library = Path(folder) / "loop.c", Path(folder) / "loop.so"
        file.write_text(source)
        done = subprocess.run(
            [compiler(), *FLAGS, "-shared", "-fPIC", "-o", library, file, "-lm"],
            capture_output=True,
            text=True,
        )
        if done.returncode != 0:
            line = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[0]
            raise NoCompilerError(f"the C compiler failed: {line}")
        function = ctypes.CDLL(str(library)).c_drive_loop
    pointer = ctypes.c_void_p
    function.argtypes = [ctypes.c_int, pointer, pointer, pointer, pointer]
    function.restype = None
    return function
