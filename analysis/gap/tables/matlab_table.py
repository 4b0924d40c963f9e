"""MATLAB .mat files: versions 5 to 7 by scipy, 7.3 by h5py."""

import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from . import hdf5_table
from .base import Array, Signals, broken, grouped, in_blocks, numbers, one_table

SUFFIXES = (".mat",)
FORMAT = "MATLAB"
WANTED = "a MATLAB file of version 5 to 7.3"
DEEPEST = 12
SIGNATURE = b"\x89HDF\r\n\x1a\n"  # MATLAB 7.3 puts it after a header of 512 bytes


def read(path: Path) -> list[Signals]:
    """Groups of variables on one clock; fields of structures are named ``structure.field``.

    Simulink's structure with time is understood; timeseries objects are not (MATLAB alone can read
    them): save ``struct(ts)`` or ``[ts.Time ts.Data]`` instead.
    """
    if _is_hdf5(path):
        return grouped(hdf5_table.read_arrays(path, ".", transposed=True))
    arrays: dict[str, Array] = {}
    objects: list[str] = []
    for name, value in _load(path).items():
        if not name.startswith("__"):
            _flatten(name, value, arrays, objects, 0)
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


def _is_hdf5(path: Path) -> bool:
    with open(path, "rb") as file:
        head = file.read(520)
    return SIGNATURE in (head[:8], head[512:520])


def _load(path: Path) -> dict[str, Any]:
    from scipy.io import loadmat

    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # duplicate variables, unknown objects
            return dict(loadmat(path, simplify_cells=True))
    # scipy's reader raises whatever a damaged tag leads it to.
    except Exception as error:
        raise broken(path, WANTED, error) from None


def _flatten(
    name: str, value: Any, arrays: dict[str, Array], objects: list[str], depth: int
) -> None:
    if depth > DEEPEST:
        return
    if isinstance(value, dict):
        for key, item in value.items():
            _flatten(f"{name}.{key}", item, arrays, objects, depth + 1)
    elif isinstance(value, list) or (isinstance(value, np.ndarray) and value.dtype == object):
        for i, item in enumerate(np.ravel(np.asarray(value, dtype=object))[:1000]):
            _flatten(f"{name}.{_label(item, i)}", item, arrays, objects, depth + 1)
    elif value.__class__.__name__ in ("MatlabOpaque", "MatlabFunction"):
        objects.append(name)
    else:
        array = numbers(value)
        if array is not None:
            arrays[name] = array


def _label(item: Any, i: int) -> str:
    """Name of an element of a structure array by its own label, as Simulink and dSPACE write it."""
    if isinstance(item, dict):
        for key in ("label", "Name", "name"):
            text = item.get(key)
            if isinstance(text, str) and text.strip():
                return text.strip()
    return str(i)
