"""The process that reads one MATLAB file: ``python -m ...matlab_child FILE RESULT``.

A damaged file can crash scipy's compiled reader or keep it busy for ever. In a process of its own that
costs the caller nothing but an error; ``matlab_table`` starts it and reads the result.
"""

import json
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np

from .base import Array, numbers

DEEPEST = 12
NAMES = "names"  # the entry of the result that holds, as JSON, the names of its arrays and objects


def main(path: str, result: str) -> None:
    """Write the numeric arrays of ``path`` to ``result`` (.npz), or end with the reason in one line."""
    try:
        arrays, objects = _read(path)
        names = json.dumps([list(arrays), objects]).encode()
        entries = {str(i): array for i, array in enumerate(arrays.values())}
        entries[NAMES] = np.frombuffer(names, dtype=np.uint8)
        np.savez(result, allow_pickle=False, **entries)
    # scipy's reader raises whatever a damaged tag leads it to.
    except Exception as error:
        sys.exit(next(iter(str(error).strip().splitlines()), type(error).__name__))


def load(result: Path) -> tuple[dict[str, Array], list[str]]:
    """What ``main`` wrote: arrays (float64, one or two dimensions) and the names of objects."""
    with np.load(result, allow_pickle=False) as entries:
        names, objects = json.loads(entries[NAMES].tobytes())
        return {name: entries[str(i)] for i, name in enumerate(names)}, objects


def _read(path: str) -> tuple[dict[str, Array], list[str]]:
    from scipy.io import loadmat

    arrays: dict[str, Array] = {}
    objects: list[str] = []
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # duplicate variables, unknown objects
        variables = loadmat(path, appendmat=False, simplify_cells=True)
    for name, value in variables.items():
        if not name.startswith("__"):
            _flatten(name, value, arrays, objects, 0)
    return arrays, objects


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


if __name__ == "__main__":
    main(*sys.argv[1:])
