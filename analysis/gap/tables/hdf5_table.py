"""HDF5, by h5py; MATLAB 7.3 files are HDF5, too."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .base import BLOCK, Array, Signals, broken, grouped, in_blocks, numbers, one_table, optional

SUFFIXES = (".h5", ".hdf5", ".hdf")
FORMAT = "HDF5"
WANTED = "an HDF5 file"
# What h5py raises for damaged files.
DAMAGE = (
    OSError, RuntimeError, ValueError, KeyError, TypeError, MemoryError, OverflowError,
)  # fmt: skip
DEEPEST = 12  # groups within groups
SEPARATOR = "/"
HOLLOW = 1000  # times what is stored; no measured signal can be compressed that far


def read(path: Path) -> list[Signals]:
    """Groups of datasets on one clock; names are paths inside the file."""
    return grouped(read_arrays(path, SEPARATOR), SEPARATOR)


def blocks(path: Path, names: Sequence[str]) -> Iterator[Array]:
    """Blocks of the datasets ``names``, in that order, read piece by piece where they are datasets."""
    h5py = optional("h5py", "hdf5", path)
    try:
        with h5py.File(path, "r") as file:
            sets = [file.get(name) for name in names]
            for item in sets:
                if isinstance(item, h5py.Dataset):
                    _refuse_hollow(item)
            if all(_is_column(h5py, s) for s in sets) and len({s.shape for s in sets}) == 1:
                for first in range(0, sets[0].shape[0], BLOCK):
                    part = [np.asarray(s[first : first + BLOCK], dtype=np.float64) for s in sets]
                    yield np.column_stack(part)
                return
    except DAMAGE as error:
        raise broken(path, WANTED, error) from None
    yield from in_blocks(one_table(path, read(path), names), names)


def read_arrays(path: Path, separator: str, transposed: bool = False) -> dict[str, Array]:
    """Numeric arrays of the file by their path; MATLAB writes them transposed."""
    h5py = optional("h5py", "hdf5", path)
    found: dict[str, Array] = {}

    def take(name: str, item: Any, depth: int) -> None:
        if isinstance(item, h5py.Group):
            if depth < DEEPEST and not name.startswith("#"):
                for key in item:
                    take(f"{name}{separator}{key}" if name else key, item.get(key), depth + 1)
        elif isinstance(item, h5py.Dataset):
            _refuse_hollow(item)
            for key, value in _values(h5py, item, separator):
                array = numbers(value.T if transposed and value.ndim > 1 else value)
                if array is not None and item.attrs.get("MATLAB_class", b"") != b"char":
                    found[f"{name}{key}"] = array

    try:
        with h5py.File(path, "r") as file:
            take("", file, 0)
    except DAMAGE as error:
        raise broken(path, WANTED, error) from None
    if not any(a.size > 1 for a in found.values()):
        raise broken(path, "datasets of numbers", "no array of numbers")
    return found


def _values(h5py: Any, item: Any, separator: str) -> Iterator[tuple[str, Any]]:
    """The dataset itself, or each field of a compound one."""
    if item.dtype.names:
        table = item[()]
        for field in item.dtype.names:
            yield f"{separator}{field}", table[field]
    elif item.dtype.kind in "biuf":
        yield "", item[()]


def _refuse_hollow(item: Any) -> None:
    """Refuse a dataset that claims far more numbers than the file holds: a damaged header."""
    stored = item.id.get_storage_size()
    if item.nbytes > HOLLOW * max(stored, 4096):
        raise ValueError(f"{item.name} claims {item.nbytes:.3g} bytes, {stored} are stored")


def _is_column(h5py: Any, item: Any) -> bool:
    return isinstance(item, h5py.Dataset) and item.ndim == 1 and item.dtype.kind in "biuf"
