"""Text tables as people write them: separator, header, units row and decimal comma are found out."""

import csv
import itertools
import re
from collections.abc import Iterable, Iterator
from datetime import datetime
from pathlib import Path
from typing import IO

import numpy as np

from ...errors import InputError
from .base import BLOCK, Array, Signals

SEPARATORS = (",", ";", "\t", "|", " ")
HEAD = 60  # lines that the layout is judged by
LONGEST = 1 << 20  # characters of one line
COMMENTS = ("#", "%", "//", "sep=")
UNIT = re.compile(r"^(.*?)\s*[\[(]([^\[\]()]*)[\])]\s*$")  # "q [rad]", "force (N)"


def read_any(path: Path, stream: IO[str]) -> Signals:
    """Numeric columns of a text table; text columns are left out and named in the remarks."""
    rows = _rows(path, stream)
    head = list(itertools.islice(rows, HEAD))
    if not head:
        raise InputError(path, "no rows", "a table with numbers")
    separator = _separator(head)
    comma = separator != "," and _decimal_comma(head, separator)
    cells = _cells(itertools.chain(head, rows), separator)
    first = next(cells)
    names, units = _names(first, comma)
    body: Iterator[list[str]] = cells
    if names is None:
        names, body = [f"column{i}" for i in range(len(first))], itertools.chain([first], cells)
    second = next(body, None)
    if second is not None and not _numeric(second, comma):
        units = units or dict(zip(names, (cell.strip().strip("[]()") for cell in second)))
    elif second is not None:
        body = itertools.chain([second], body)
    columns, dropped = _columns(path, body, names, comma)
    remarks = [f"left out, not numbers: {', '.join(dropped)}"] if dropped else []
    if comma:
        remarks.append("numbers have a decimal comma")
    return Signals(name="", columns=columns, units=units, remarks=tuple(remarks))


def _rows(path: Path, stream: IO[str]) -> Iterator[str]:
    while line := stream.readline(LONGEST):
        if len(line) == LONGEST:
            raise InputError(path, "a line of more than a million characters", "rows of a table")
        text = line.strip("\r\n\ufeff")
        if text.strip() and "\0" in text:
            raise InputError(path, "binary data", "a text table")
        bare = text.lstrip("#% ")  # a header line may be commented out
        if text.strip() and (not text.lstrip().startswith(COMMENTS) or _looks_like_header(bare)):
            yield bare if text.lstrip().startswith(("#", "%")) else text


def _looks_like_header(text: str) -> bool:
    return bool(re.match(r"^(t|time|timestamp)\b[^:=]*[,;\t|]", text, re.IGNORECASE))


def _separator(head: list[str]) -> str:
    """The separator that cuts most lines into the same number of cells, more than one."""

    def score(separator: str) -> tuple[float, int]:
        counts = [len(cells) for cells in _cells(head, separator)]
        common = max(set(counts), key=counts.count)
        return (counts.count(common) / len(counts) if common > 1 else 0.0, common)

    # 1,5;2,5 is cut evenly by both; a semicolon or tabulator is then the separator.
    best = max(score(s)[0] for s in SEPARATORS)
    if best == 0.0:
        return ","
    strong = [s for s in (";", "\t", "|") if score(s)[0] == best]
    return strong[0] if strong else max(SEPARATORS, key=score)


def _cells(lines: Iterable[str], separator: str) -> Iterator[list[str]]:
    if separator == " ":
        return (line.split() for line in lines)
    return csv.reader(lines, delimiter=separator)


def _decimal_comma(head: list[str], separator: str) -> bool:
    body = [cell for row in _cells(head[1:], separator) for cell in row]
    return any(re.fullmatch(r"\s*-?\d+,\d+([eE][-+]?\d+)?\s*", cell) for cell in body)


def _names(cells: list[str], comma: bool) -> tuple[list[str] | None, dict[str, str]]:
    """Unique names and the units written with them; no names where the row holds numbers."""
    if _numeric(cells, comma):
        return None, {}
    names: list[str] = []
    units: dict[str, str] = {}
    for i, cell in enumerate(cells):
        found = UNIT.match(cell.strip())
        name = (found.group(1) if found else cell.strip()) or f"column{i}"
        while name in names:
            name += "_"
        names.append(name)
        if found and found.group(1):
            units[name] = found.group(2).strip()
    return names, units


def _numeric(cells: list[str], comma: bool) -> bool:
    """Whether more than half of a row's cells are numbers or times."""
    found = sum(not np.isnan(_value(cell, comma)) or _blank(cell) for cell in cells)
    return 2 * found > len(cells)


def _blank(cell: str) -> bool:
    return cell.strip().lower() in ("nan", "")


def _value(cell: str, comma: bool) -> float:
    text = cell.strip()
    try:
        return float(text.replace(",", ".") if comma else text)
    except ValueError:
        pass
    if text.lower() in ("true", "false"):
        return float(text.lower() == "true")
    try:
        return datetime.fromisoformat(text).timestamp()
    except (ValueError, OverflowError, OSError):
        return np.nan


def _columns(
    path: Path, rows: Iterator[list[str]], names: list[str], comma: bool
) -> tuple[dict[str, Array], list[str]]:
    """Columns of numbers, and the names of the others; rows are turned into numbers block by block."""
    parts: list[Array] = []
    first = 0
    block = list(itertools.islice(rows, BLOCK))
    while block:
        following = list(itertools.islice(rows, BLOCK))
        whole = _whole(path, block, first, len(names), last=not following)
        if whole:
            parts.append(np.column_stack([_floats(cells, comma) for cells in zip(*whole)]))
        first += len(block)
        block = following
    if not parts:
        raise InputError(path, "no rows of numbers", "a table with numbers")
    table = np.concatenate(parts)
    usable = np.mean(np.isfinite(table), axis=0) > 0.5
    if not usable.any():
        raise InputError(path, "no column of numbers", "a table with numbers")
    columns = {n: np.ascontiguousarray(table[:, i]) for i, n in enumerate(names) if usable[i]}
    return columns, [name for i, name in enumerate(names) if not usable[i]]


def _whole(
    path: Path, rows: list[list[str]], first: int, width: int, *, last: bool
) -> list[list[str]]:
    """Rows of ``width`` cells; only the last row of a file may be cut short, and is then dropped."""
    ragged = [i for i, row in enumerate(rows) if row and len(row) != width]
    if ragged and not (last and ragged == [len(rows) - 1]):
        raise InputError(
            path,
            f"row {first + ragged[0] + 1} below the header has {len(rows[ragged[0]])} cells",
            f"{width} cells in every row",
        )
    return [row for row in rows if len(row) == width]


def _floats(cells: tuple[str, ...], comma: bool) -> Array:
    try:
        return np.array(cells, dtype=float)
    except ValueError:
        return np.array([_value(cell, comma) for cell in cells])
