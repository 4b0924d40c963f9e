"""Log sets: a folder with ``logset.yaml`` and one table per run (format 1).

Reading is strict. A file that cannot be used ends in one ``InputError`` that names the file and the
key, column or row, and says what to do. The key ``answer`` of labelled sets is dropped unread.
"""

import gzip
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from ..errors import InputError

FILE = "logset.yaml"
TOP_KEYS = frozenset(
    [
        "format",
        "name",
        "source",
        "license",
        "note",
        "system",
        "controller",
        "controllers",
        "sample_time_s",
        "columns",
        "runs",
        "published",
        "answer",
    ]
)
SHORTEST_RUN = 100  # samples; less than this says nothing about a machine
JITTER_LIMIT = 0.1  # largest deviation of a sample from the uniform clock, in sample times


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run: sampled columns on a uniform clock."""

    name: str
    use: str  # "fit" or "validate"
    controller: str  # id in LogSet.controllers
    columns: Mapping[str, NDArray[np.float64]]
    settings: Mapping[str, Any] = field(default_factory=dict)  # motion, rate_Hz, ...

    @property
    def samples(self) -> int:
        """Number of samples."""
        return int(self.columns["t"].size)

    def stack(self, *names: str) -> NDArray[np.float64]:
        """Columns side by side, (samples, len(names)), contiguous."""
        return np.column_stack([self.columns[name] for name in names])


@dataclass(frozen=True, kw_only=True)
class LogSet:
    """Runs of one machine with the description of its nominal model and controllers."""

    name: str
    folder: Path
    kind: str
    system: Mapping[str, Any]
    controllers: Mapping[str, Mapping[str, Any]]
    dt: float  # [s]
    units: Mapping[str, str]
    remarks: Mapping[str, str]  # text of each column as written, with what follows the unit
    runs: tuple[Run, ...]

    @property
    def fit(self) -> tuple[Run, ...]:
        """Runs for fitting and choosing."""
        return tuple(run for run in self.runs if run.use == "fit")

    @property
    def validate(self) -> tuple[Run, ...]:
        """Runs never used for fitting or choosing."""
        return tuple(run for run in self.runs if run.use == "validate")


def load_logset(folder: str | Path) -> LogSet:
    """Read and check a log set; raises InputError for anything that cannot be used."""
    path = Path(folder)
    description = path / FILE if path.is_dir() else path
    if not description.is_file():
        raise InputError(
            path,
            "no log set here",
            f"a folder with a file {FILE}",
            "See `gapscope diagnose --help`.",
        )
    document = _read_yaml(description)
    system = _mapping(document, "system", description)
    kind = system.get("kind")
    if not isinstance(kind, str):
        raise InputError(description, f"system.kind is {kind!r}", "the name of a machine")
    dt = document.get("sample_time_s")
    if not isinstance(dt, int | float) or not 0.0 < dt < np.inf:
        raise InputError(description, f"sample_time_s is {dt!r}", "a positive number of seconds")
    units = _units(document, description)
    controllers = _controllers(document, description)
    entries = document.get("runs")
    if not isinstance(entries, list) or not entries:
        raise InputError(description, "runs is missing or empty", "a list of runs")
    runs = tuple(
        _run(i, entry, description, units, controllers, float(dt))
        for i, entry in enumerate(entries)
    )
    if not any(run.use == "fit" for run in runs):
        raise InputError(description, "no run has use: fit", "at least one run to fit to")
    return LogSet(
        name=str(document.get("name", description.parent.name)),
        folder=description.parent,
        kind=kind,
        system=system,
        controllers=controllers,
        dt=float(dt),
        units=units,
        remarks={str(name): str(text) for name, text in document["columns"].items()},
        runs=runs,
    )


def _read_yaml(path: Path) -> dict[str, Any]:
    try:
        document = yaml.safe_load(path.read_text(encoding="utf-8"))
    except UnicodeDecodeError as error:
        raise InputError(path, f"not text: {error.reason}", "UTF-8 YAML") from None
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = f"{path}, line {mark.line + 1}" if mark else path
        raise InputError(where, "not valid YAML", "a mapping of keys to values") from None
    except RecursionError:
        raise InputError(path, "YAML nested too deeply", "a mapping of keys to values") from None
    if not isinstance(document, dict):
        raise InputError(path, "no keys", "a mapping of keys to values")
    document.pop("answer", None)
    unknown = sorted(str(key) for key in document if key not in TOP_KEYS)
    if unknown:
        raise InputError(
            path, f"unknown key {unknown[0]!r}", f"one of {', '.join(sorted(TOP_KEYS))}"
        )
    if document.get("format") != 1:
        raise InputError(path, f"format is {document.get('format')!r}", "format: 1")
    return document


def _mapping(document: Mapping[str, Any], key: str, path: Path) -> dict[str, Any]:
    value = document.get(key)
    if not isinstance(value, dict):
        raise InputError(path, f"{key} is missing or not a mapping", f"{key}: with keys of its own")
    return value


def _units(document: Mapping[str, Any], path: Path) -> dict[str, str]:
    columns = _mapping(document, "columns", path)
    if "t" not in columns:
        raise InputError(path, "columns has no t", "a time column `t: s`")
    # "rad, 13-bit encoder" and "N = 35.15*u" are units with a remark.
    units = {str(name): re.split("[,=]", str(text))[0].strip() for name, text in columns.items()}
    if units["t"] != "s":
        raise InputError(
            path, f"columns.t has the unit {units['t']!r}", "seconds, `t: s`", "Convert the times."
        )
    return units


def _controllers(document: Mapping[str, Any], path: Path) -> dict[str, dict[str, Any]]:
    if "controllers" in document:
        controllers = _mapping(document, "controllers", path)
        for name, value in controllers.items():
            if not isinstance(value, dict):
                raise InputError(path, f"controllers.{name} is {value!r}", "a mapping of settings")
        return {str(name): value for name, value in controllers.items()}
    return {"controller": _mapping(document, "controller", path)}


def _run(
    i: int,
    entry: Any,
    path: Path,
    units: Mapping[str, str],
    controllers: Mapping[str, Any],
    dt: float,
) -> Run:
    where = f"{path}, runs[{i}]"
    if not isinstance(entry, dict) or not isinstance(entry.get("file"), str):
        raise InputError(where, "no file", "`file: NAME.csv`")
    use = entry.get("use")
    if use not in ("fit", "validate"):
        raise InputError(where, f"use is {use!r}", "fit or validate")
    controller = str(entry.get("controller", next(iter(controllers))))
    if controller not in controllers:
        raise InputError(
            where, f"controller is {controller!r}", f"one of {', '.join(sorted(controllers))}"
        )
    table = (path.parent / entry["file"]).resolve()
    if not table.is_relative_to(path.parent.resolve()):
        raise InputError(where, f"file {entry['file']!r} is outside the log set", "a file in it")
    columns = read_table(table, list(units))
    _check_clock(table, columns["t"], dt)
    settings = {
        key: value for key, value in entry.items() if key not in ("file", "use", "controller")
    }
    return Run(
        name=entry["file"], use=use, controller=controller, columns=columns, settings=settings
    )


def read_table(path: Path, names: list[str]) -> dict[str, NDArray[np.float64]]:
    """Columns ``names`` of a comma-separated table with one header line, optionally gzipped."""
    if not path.is_file():
        raise InputError(path, "file not found", "the table of a run")
    opener = gzip.open if path.suffix == ".gz" else open
    try:
        with opener(path, "rt", encoding="utf-8") as stream:
            header = [name.strip() for name in stream.readline().split(",")]
            missing = [name for name in names if name not in header]
            if missing:
                raise InputError(
                    path,
                    f"no column {missing[0]!r}",
                    f"the columns of {FILE}: {', '.join(names)}",
                    f"The table has {', '.join(header)[:200]}.",
                )
            values = np.loadtxt(stream, delimiter=",", ndmin=2, dtype=float)
    except (ValueError, OSError, EOFError, UnicodeDecodeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            path, f"unreadable table ({error})", f"{len(header)} numbers in every row",
            "A last row that is cut short usually means a truncated file.",
        ) from None  # fmt: skip
    if values.shape[0] < SHORTEST_RUN or values.shape[1] != len(header):
        raise InputError(
            path,
            f"{values.shape[0]} rows of {values.shape[1]} numbers",
            f"at least {SHORTEST_RUN} rows of {len(header)}",
        )
    columns = {name: np.ascontiguousarray(values[:, header.index(name)]) for name in names}
    for name, column in columns.items():
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise InputError(
                f"{path}, row {bad[0] + 2}, column {name}",
                f"{column[bad[0]]} ({bad.size} such values)",
                "a finite number",
                "Cut the run or fill the gap before diagnosing.",
            )
    return columns


def _check_clock(path: Path, t: NDArray[np.float64], dt: float) -> None:
    steps = np.diff(t)
    backward = np.flatnonzero(steps <= 0.0)
    if backward.size:
        row = int(backward[0])
        raise InputError(
            f"{path}, row {row + 3}, column t",
            f"time goes from {t[row]:g} to {t[row + 1]:g} s",
            "times that increase",
        )
    mean = (t[-1] - t[0]) / steps.size
    if abs(mean - dt) > 1e-3 * dt:
        raise InputError(
            f"{path}, column t", f"the mean interval is {mean:g} s", f"sample_time_s = {dt:g} s"
        )
    worst = float(np.max(np.abs(t - (t[0] + dt * np.arange(t.size)))))
    if worst > JITTER_LIMIT * dt or np.max(np.abs(steps - dt)) > JITTER_LIMIT * dt:
        row = int(np.argmax(np.abs(steps - dt)))
        raise InputError(
            f"{path}, row {row + 3}, column t",
            f"the clock jitters by up to {worst:g} s",
            f"uniform steps of {dt:g} s within {100 * JITTER_LIMIT:.0f} %",
            "Resample the log to a uniform clock.",
        )
