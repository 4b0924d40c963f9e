"""MATLAB .mat files: versions 4 to 7 by scipy in a process of its own, 7.3 by h5py."""

import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator, Sequence
from pathlib import Path

from ...errors import InputError
from . import hdf5_table, matlab_child
from .base import Array, Signals, broken, grouped, in_blocks, one_table

SUFFIXES = (".mat",)
FORMAT = "MATLAB"
WANTED = "a MATLAB file of version 5 to 7.3"
SIGNATURE = b"\x89HDF\r\n\x1a\n"  # MATLAB 7.3 puts it after a header of 512 bytes
VERSIONS = (b"\x00\x01IM", b"\x01\x00MI")  # end of the header of versions 5 to 7, by byte order
READER = matlab_child.__name__  # the module that the reading process runs
PATIENCE = 60.0  # [s] that the reading process gets for any file, and
SLOWEST = 2e6  # [byte/s] for its length
DAMAGED = "The file is probably damaged: copy it again, or save it again in MATLAB."


def read(path: Path) -> list[Signals]:
    """Groups of variables on one clock; fields of structures are named ``structure.field``.

    Simulink's structure with time is understood; timeseries objects are not (MATLAB alone can read
    them): save ``struct(ts)`` or ``[ts.Time ts.Data]`` instead.
    """
    with open(path, "rb") as file:
        head = file.read(520)
    if SIGNATURE in (head[:8], head[512:520]):
        return grouped(hdf5_table.read_arrays(path, ".", transposed=True))
    # The first number of version 4 is below 5000, so that one of its bytes is zero.
    if 0 not in head[:4] and head[124:128] not in VERSIONS:
        raise broken(path, WANTED, "its header is not one that MATLAB writes")
    arrays, objects = _in_a_child(path)
    if not any(array.size > 1 for array in arrays.values()):
        what = f"only objects such as {objects[0]!r}" if objects else "no array of numbers"
        raise InputError(
            path, what, "arrays or structures",
            "In MATLAB, save [ts.Time ts.Data] of a timeseries instead of the object.",
        )  # fmt: skip
    return grouped(arrays)


def blocks(path: Path, names: Sequence[str]) -> Iterator[Array]:
    """Blocks of the columns ``names``; the file itself is read whole (these versions end at 2 GB)."""
    return in_blocks(one_table(path, read(path), names), names)


def _in_a_child(path: Path) -> tuple[dict[str, Array], list[str]]:
    """Arrays and names of objects; InputError where the reader refuses, crashes or does not end."""
    limit = PATIENCE + path.stat().st_size / SLOWEST
    with tempfile.TemporaryDirectory(prefix="gapscope-") as folder:
        result = Path(folder) / "arrays.npz"
        # -P: nothing that lies in the working directory is imported.
        command = [sys.executable, "-P", "-m", READER, str(path), str(result)]
        try:
            done = subprocess.run(
                command, stdin=subprocess.DEVNULL, capture_output=True, timeout=limit, check=False
            )
        except subprocess.TimeoutExpired:
            raise InputError(path, f"not read within {limit:.0f} s", WANTED, DAMAGED) from None
        if done.returncode < 0:
            name = signal.Signals(-done.returncode).name
            raise InputError(path, f"it crashed its reader ({name})", WANTED, DAMAGED)
        if done.returncode:
            lines = done.stderr.decode(errors="replace").strip().splitlines()
            raise broken(path, WANTED, lines[-1] if lines else f"exit code {done.returncode}")
        return matlab_child.load(result)
