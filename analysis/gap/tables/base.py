"""What a reader of one file format supplies, and what the readers share."""

import importlib
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError

Array = NDArray[np.float64]

BLOCK = 1 << 17  # rows that are in memory at once while a long table is streamed
WIDEST = 64  # columns of a two-dimensional array that are still taken for signals
TIME_NAME = re.compile(r"^(t|time|times|timestamp|tout|stamp|secs?|seconds|zeit)$", re.IGNORECASE)


@dataclass(frozen=True, kw_only=True)
class Signals:
    """Columns of equal length on one clock, as a file holds them."""

    name: str  # of the topic, group or structure; empty for the only table of a file
    columns: Mapping[str, Array]  # (samples,) each
    units: Mapping[str, str] = field(default_factory=dict)  # where the file states them
    time: str | None = None  # the column that the format itself says is time
    remarks: tuple[str, ...] = ()  # what was left out or had to be decided while reading

    @property
    def samples(self) -> int:
        """Number of samples."""
        return next((int(c.size) for c in self.columns.values()), 0)


def optional(module: str, extra: str, path: Path) -> Any:
    """Import a module of an optional extra; InputError names the command that installs it."""
    try:
        return importlib.import_module(module)
    except ImportError:
        raise InputError(
            path,
            f"the reader of this format is not installed (no module {module!r})",
            f"the optional extra {extra!r}",
            f"Install it: pip install 'gapscope[{extra}]'",
        ) from None


def broken(path: Path, wanted: str, error: Exception | str) -> InputError:
    """The error for a file that its format's reader refuses; only the first line is shown."""
    text = str(error).strip().splitlines()
    reason = (text[0] if text else type(error).__name__)[:200]
    return InputError(path, f"unreadable ({reason})", wanted, "The file may be cut short.")


def one_table(path: Path, groups: Sequence[Signals], names: Sequence[str]) -> Signals:
    """The first group that has all names; InputError names the column that is missing."""
    for group in groups:
        if all(name in group.columns for name in names):
            return group
    known = list(dict.fromkeys(name for group in groups for name in group.columns))
    missing = [name for name in names if name not in known]
    if not missing:
        raise InputError(
            path, f"no single clock has all of {', '.join(names)}", "columns of one table",
            "Run `gapscope import` to bring the signals onto one clock.",
        )  # fmt: skip
    raise no_column(path, missing[0], names, known)


def no_column(path: Path, name: str, names: Sequence[str], known: Sequence[str]) -> InputError:
    """The error for a column that a table lacks."""
    return InputError(
        path, f"no column {name!r}", f"the columns of logset.yaml: {', '.join(names)}",
        f"The table has {', '.join(known)[:200]}.",
    )  # fmt: skip


def in_blocks(group: Signals, names: Sequence[str]) -> Iterator[Array]:
    """Blocks of a table that is in memory."""
    for first in range(0, group.samples, BLOCK):
        yield np.column_stack([group.columns[name][first : first + BLOCK] for name in names])


def numbers(value: Any) -> Array | None:
    """An array of real numbers as float64 of one or two dimensions; None for anything else."""
    array = np.asarray(value)
    if array.dtype.kind not in "biuf" or array.size == 0:
        return None
    array = np.squeeze(array).astype(np.float64)
    if array.ndim == 0:
        return array.reshape(1)
    return array if array.ndim <= 2 else None


def grouped(arrays: Mapping[str, Array], separator: str = ".") -> list[Signals]:
    """Signals of a container of named arrays, such as a MATLAB workspace or an HDF5 file.

    A structure that holds a time of its own is a group; the other arrays are grouped by length.
    Two-dimensional arrays become one column per signal along their longer side. Scalars are dropped.
    """
    flat = {name: column for key, value in arrays.items() for name, column in _split(key, value)}
    groups: dict[tuple[str, int], dict[str, Array]] = {}
    times = {_cut(n, separator)[0]: c.size for n, c in flat.items() if _is_time(n, separator)}
    for name, column in flat.items():
        parent = _owner(name, column.size, times, separator)
        groups.setdefault((parent, column.size), {})[name] = column
    found = []
    for (parent, _), columns in groups.items():
        prefix = f"{parent}{separator}" if parent else ""
        short = {n.removeprefix(prefix): c for n, c in columns.items()}
        time = next((n for n in short if _is_time(n, separator)), None)
        found.append(Signals(name=parent, columns=short, time=time))
    return sorted(found, key=lambda group: -group.samples)


def _split(name: str, value: Array) -> Iterator[tuple[str, Array]]:
    if value.ndim == 1 and value.size > 1:
        yield name, value
    elif value.ndim == 2:
        tall = value if value.shape[0] >= value.shape[1] else value.T
        if tall.shape[1] <= WIDEST:
            for i in range(tall.shape[1]):
                yield f"{name}[{i}]", np.ascontiguousarray(tall[:, i])


def _cut(name: str, separator: str) -> tuple[str, str]:
    parent, found, last = name.rpartition(separator)
    return (parent, last) if found else ("", name)


def _is_time(name: str, separator: str) -> bool:
    return bool(TIME_NAME.match(_cut(name, separator)[1]))


def _owner(name: str, size: int, times: Mapping[str, int], separator: str) -> str:
    """The nearest structure around ``name`` with a time of the same length, or the whole file."""
    parent = _cut(name, separator)[0]
    while parent:
        if times.get(parent) == size:
            return parent
        parent = _cut(parent, separator)[0]
    return ""
