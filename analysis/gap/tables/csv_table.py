"""Comma-separated values with one header line, optionally gzipped."""

import gzip
import itertools
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO

import numpy as np

from ...errors import InputError
from .base import BLOCK, Array, Signals, no_column
from .dialect import read_any

SUFFIXES = (".csv", ".txt", ".tsv", ".dat")
FORMAT = "CSV"
LONGEST_LINE = 1 << 20  # characters; a longer line is no row of a table


def read(path: Path) -> list[Signals]:
    """The one table of the file, whatever its separator, header and units row."""
    with _readable(path, "rows of numbers below a header line"), _open(path) as stream:
        return [read_any(path, stream)]


def blocks(path: Path, names: Sequence[str]) -> Iterator[Array]:
    """Blocks of the columns ``names``, in that order."""
    row = 2
    with _readable(path, "rows of numbers"), _open(path) as stream:
        header = _header(path, stream)
        missing = [name for name in names if name not in header]
        if missing:
            raise no_column(path, missing[0], names, header)
        pick = [header.index(name) for name in names]
        while lines := list(itertools.islice(stream, BLOCK)):
            yield _parse(path, lines, row, len(header))[:, pick]
            row += len(lines)


def _parse(path: Path, lines: list[str], row: int, width: int) -> Array:
    filled = [line for line in lines if line.strip()]
    if not filled:
        return np.empty((0, width))
    try:
        values = np.loadtxt(filled, delimiter=",", ndmin=2, dtype=float, comments=None)
        if values.shape[1] == width:
            return values
        found = f"rows of {values.shape[1]} numbers"
    except ValueError as error:
        found = str(error)
    for i, line in enumerate(lines):
        cells = line.split(",")
        if line.strip() and not (len(cells) == width and all(_number(c) for c in cells)):
            found = f"row {row + i}: {line.strip()[:60]!r}"
            break
    raise InputError(
        path, f"unreadable table ({found})", f"{width} numbers in every row",
        "A last row that is cut short usually means a truncated file.",
    )  # fmt: skip


def _number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _header(path: Path, stream: IO[str]) -> list[str]:
    line = stream.readline(LONGEST_LINE)
    header = [name.strip().strip('"') for name in line.lstrip("\ufeff").split(",")]
    twice = [name for i, name in enumerate(header) if name in header[:i]]
    if twice:
        raise InputError(path, f"two columns {twice[0]!r}", "each column once in the header line")
    return header


def _open(path: Path) -> IO[str]:
    if path.suffix == ".gz":
        return gzip.open(path, "rt", encoding="utf-8-sig")
    return open(path, encoding="utf-8-sig")


class _readable:
    """Turn what a damaged or binary file raises into one InputError."""

    def __init__(self, path: Path, wanted: str) -> None:
        self._path, self._wanted = path, wanted

    def __enter__(self) -> None:
        pass

    def __exit__(self, kind: object, error: BaseException | None, trace: object) -> None:
        if isinstance(error, OSError) and error.errno is not None:
            return  # of the disk, not of what is in the file
        if isinstance(error, UnicodeDecodeError | OSError | EOFError | zlib.error):
            reason = getattr(error, "reason", None) or error
            raise InputError(
                self._path, f"unreadable table ({reason})", self._wanted,
                "The file may be cut short, or of another format than its name says.",
            ) from None  # fmt: skip
