"""The hand-written C loops, compiled on this machine when it is asked for."""

import ctypes
import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable, Sequence
from importlib import resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FLAGS = ("-O3", "-march=native")
# GCC 12 vectorises tanh only in fast mathematics, and this loop only without redundancy elimination.
BATCH_FLAGS = (*FLAGS, "-ffast-math", "-fopenmp", "-fno-tree-pre")
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
    function = _load("c_drive_loop", FLAGS, integers=1, arrays=4)
    reference = np.ascontiguousarray(reference)
    samples = len(reference)

    def run() -> tuple[Signals, Signals]:
        measured, command = np.empty((samples, 2)), np.empty((samples, 2))
        function(samples, *(a.ctypes.data for a in (reference, constants, measured, command)))
        return measured, command

    return run


def c_batch(
    reference: Signals, table: Signals, constants: Signals
) -> Callable[[], NDArray[np.float64]]:
    """Many loops on ``reference`` (samples, 2) [rad]; each call returns tracking errors (sets,) [rad RMS].

    ``table`` (sets, 6) and ``constants`` (5,) are those of the structs in ``c_drive_batch.c``, which is
    vectorised and has as many threads as OpenMP gives it. Raises NoCompilerError.
    """
    function = _load("c_drive_batch", BATCH_FLAGS, integers=2, arrays=4)
    reference, table = np.ascontiguousarray(reference), np.ascontiguousarray(table)

    def run() -> NDArray[np.float64]:
        rms = np.empty(len(table))
        arrays = (array.ctypes.data for array in (reference, table, constants, rms))
        function(len(table), len(reference), *arrays)
        return rms

    return run


def _load(name: str, flags: Sequence[str], integers: int, arrays: int) -> Any:
    """The C function ``name`` of the file of that name, called with integers, then arrays."""
    source = resources.files(__package__).joinpath(f"{name}.c").read_text()
    with tempfile.TemporaryDirectory(prefix="gapscope-bench-") as folder:
        file, loop, library = (Path(folder) / f"loop.{end}" for end in ("c", "o", "so"))
        file.write_text(source)
        _run([compiler(), *flags, "-fPIC", "-c", "-o", loop, file])
        # Linked without -ffast-math, which would switch off subnormal numbers in this whole process.
        threads = [flag for flag in flags if flag == "-fopenmp"]
        _run([compiler(), *threads, "-shared", "-o", library, loop, "-lm"])
        function = getattr(ctypes.CDLL(str(library)), name)
    function.argtypes = [ctypes.c_int] * integers + [ctypes.c_void_p] * arrays
    function.restype = None
    return function


def _run(command: Sequence[str | Path]) -> None:
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        line = (done.stderr.strip() or f"exit code {done.returncode}").splitlines()[0]
        raise NoCompilerError(f"the C compiler failed: {line}")
