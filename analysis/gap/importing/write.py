"""Carrying out an import: the tables on one clock and in the units of the log set, and its description."""

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ...errors import InputError
from ...files import write_folder
from ..description import FILE
from ..sampling import SHORTEST_RUN
from ..tables import Array, Signals, read
from ..tables.base import optional
from .clock import on_one_clock
from .plan import Plan, controller_of_runs, scale, values
from .units import factor

FORMATS = ("csv", "csv.gz", "parquet")


@dataclass(frozen=True, kw_only=True)
class Imported:
    """A log set ready to be written."""

    document: Mapping[str, Any]  # logset.yaml
    tables: Mapping[str, Mapping[str, Array]]  # by file name

    def save(self, out: Path) -> list[Path]:
        """Write all files into the folder ``out``, whole or not at all."""
        text = yaml.safe_dump(dict(self.document), sort_keys=False, allow_unicode=True)
        writers = {n: lambda path, n=n: _write(path, self.tables[n]) for n in self.tables}
        return write_folder(
            out, {**writers, FILE: lambda path: path.write_text(text, encoding="utf-8")}
        )


def carry_out(
    plan: Plan,
    paths: Sequence[Path],
    *,
    name: str,
    system: Mapping[str, Any],
    validate: Sequence[Path] = (),
    controllers: Sequence[str] = (),
    sample_time: float | None = None,
    rate: float | None = None,
    resample: bool = False,
    form: str = "csv",
) -> Imported:
    """Bring every file onto one uniform clock in the units of the log set.

    ``system`` has the keys ``system`` and ``controller(s)``; files in ``validate`` become validation
    runs; ``controllers`` says which of several each file was recorded under (ID, or FILE=ID); ``rate``
    [Hz] counts rows instead of times; ``form`` is one of FORMATS. Raises InputError for missing
    columns, units that do not convert, a controller that is open, and clocks that need ``resample``.
    """
    plan.require_all()
    controller = controller_of_runs(system, paths, controllers)
    dt = sample_time or (1.0 / rate if rate else None)
    tables: dict[str, Mapping[str, Array]] = {}
    runs, remarks = [], []
    for path in paths:
        groups = plan.groups if path == plan.path else tuple(read(path))
        base, columns = _columns(plan, path, groups, rate)
        table, step, notes = on_one_clock(path, columns, base, dt, resample)
        dt = dt or step
        if len(table["t"]) < SHORTEST_RUN:
            raise InputError(path, f"{len(table['t'])} samples", f"at least {SHORTEST_RUN}")
        file = _file_name(path, form, tables)
        tables[file] = table
        chosen = {"controller": controller[path]} if path in controller else {}
        runs.append({"file": file, **chosen, "use": "validate" if path in validate else "fit"})
        remarks.extend(notes)
        remarks.extend(f"{path.name}: {text}." for group in groups for text in group.remarks)
    document = {
        "format": 1,
        "name": name,
        "source": f"gapscope import of {', '.join(path.name for path in paths)}",
        **system,
        "sample_time_s": dt,
        "columns": {"t": "s", **{n: plan.texts[n] for n in plan.columns}},
        **({"remarks": list(dict.fromkeys(remarks))} if remarks else {}),
        "runs": runs,
    }
    return Imported(document=document, tables=tables)


def _columns(
    plan: Plan, path: Path, groups: Sequence[Signals], rate: float | None
) -> tuple[Array, dict[str, tuple[Array, Array]]]:
    """Times of the common clock, and times and values of every column in the log set's units."""
    clocks: dict[str, Array] = {}

    def clock(group: str) -> Array:
        if group not in clocks:
            clocks[group] = _times(plan, path, groups, group, rate)
        return clocks[group]

    columns = {}
    for name, guess in plan.columns.items():
        column = scale(name, guess, plan.texts[name]) * values(path, groups, guess.source)
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise InputError(
                f"{path}, row {bad[0] + 2}, column {guess.source}",
                f"{column[bad[0]]} ({bad.size} such values)", "finite numbers",
                "Cut the run or fill the gap before importing.",
            )  # fmt: skip
        columns[name] = (clock(guess.source.group), column)
    if not columns:
        raise InputError(path, "no column to import", "at least one column beside the time")
    owner = plan.time.source.group if plan.time else next(iter(plan.columns.values())).source.group
    return clock(owner), columns


def _times(
    plan: Plan, path: Path, groups: Sequence[Signals], group: str, rate: float | None
) -> Array:
    """Times of a group's rows [s]."""
    from .guess import time_of

    if rate is not None:
        size = next(g.samples for g in groups if g.name == group)
        return np.arange(size) / rate
    found = plan.time
    if found is None or found.source.group != group:
        found = next((time_of(g) for g in groups if g.name == group), None)
    if found is None:
        raise InputError(path, f"{group or 'the table'} has no times", "increasing times")
    t = values(path, groups, found.source) * (factor(found.unit, "s") or 1.0)
    if t.size < 2 or not np.all(np.diff(t) > 0.0):
        raise InputError(
            f"{path}, column {found.source}", "time does not increase", "increasing times"
        )
    return t


def _file_name(path: Path, form: str, taken: Mapping[str, Any]) -> str:
    stem = path.name.split(".")[0] or "run"
    name, i = f"{stem}.{form}", 2
    while name in taken:
        name, i = f"{stem}-{i}.{form}", i + 1
    return name


def _write(path: Path, table: Mapping[str, Array]) -> None:
    if path.name.endswith(".parquet"):
        arrow = optional("pyarrow", "parquet", path)
        parquet = optional("pyarrow.parquet", "parquet", path)
        parquet.write_table(arrow.table(dict(table)), os.fspath(path))
        return
    np.savetxt(
        path,
        np.column_stack(list(table.values())),
        delimiter=",",
        header=",".join(table),
        comments="",
        fmt="%.15g",
    )
