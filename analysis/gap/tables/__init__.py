"""Tables of runs in the formats people log in: one module per format.

``read`` gives every group of signals of a file (``gapscope import``), ``blocks`` streams named columns
of its one table in bounded memory (log sets). Formats beyond CSV and MATLAB 5-7 need an optional
extra; without it the one error names the command that installs it.
"""

from collections.abc import Iterator, Sequence
from pathlib import Path
from types import ModuleType

import numpy as np

from ...errors import InputError
from . import csv_table, hdf5_table, matlab_table, mcap_table, parquet_table, rosbag_table
from .base import BLOCK, Array, Signals

__all__ = ["BLOCK", "READERS", "Array", "Signals", "blocks", "read", "reader_of"]

READERS: tuple[ModuleType, ...] = (
    csv_table, parquet_table, matlab_table, hdf5_table, mcap_table, rosbag_table,
)  # fmt: skip


def reader_of(path: Path) -> ModuleType:
    """The reader of a file by its suffix, of a folder as a ROS 2 bag; InputError for others."""
    if not path.exists():
        raise InputError(path, "file not found", "the table of a run")
    if path.is_dir():
        if (path / "metadata.yaml").is_file():
            return rosbag_table
        raise InputError(
            path, "a folder without metadata.yaml", "a file, or the folder of a ROS 2 bag"
        )
    suffix = Path(path.stem).suffix if path.suffix == ".gz" else path.suffix
    for reader in READERS:
        if suffix.lower() in reader.SUFFIXES and (path.suffix != ".gz" or reader is csv_table):
            return reader
    known = ", ".join(f"{r.FORMAT} ({' '.join(r.SUFFIXES)})" for r in READERS)
    raise InputError(path, f"unknown format {suffix!r}", f"one of {known}; CSV also gzipped")


def read(path: Path) -> list[Signals]:
    """Every group of signals of a file, the longest first; InputError for unusable files."""
    try:
        groups: list[Signals] = reader_of(path).read(path)
    except OSError as error:
        raise _unreadable(path, error) from None
    return groups


def blocks(path: Path, names: Sequence[str]) -> Iterator[Array]:
    """Blocks (at most BLOCK rows, len(names)) of the named columns; InputError for unusable files."""
    try:
        yielded: Iterator[Array] = reader_of(path).blocks(path, names)
        for block in yielded:
            yield np.ascontiguousarray(block)
    except OSError as error:
        raise _unreadable(path, error) from None


def _unreadable(path: Path, error: OSError) -> InputError:
    return InputError(
        path, f"cannot be read ({error.strerror or error})", "a file that may be read",
        "Check its permissions and its disk.",
    )  # fmt: skip
