"""Log sets: a folder with ``logset.yaml`` and one table per run (format 1).

Where a sample is a move (``MOVE_KINDS``), rows follow no clock and no controller need be stated.

Reading is strict. A file that cannot be used ends in one ``InputError`` that names the file and the
key, column or row, and says what to do. The key ``answer`` of labelled sets is dropped unread.
"""

import hashlib
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...models.yaml_mapping import read_yaml_mapping
from ..errors import InputError
from .sampling import Piece, read_pieces

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
        "resample",
        "remarks",
        "runs",
        "published",
        "answer",
    ]
)
MODEL_FILE = "model_file"  # kind of a machine described by an URDF or SDF file
MOVE_KINDS = frozenset(["mm3a"])  # machines whose samples are moves, one after the other

LONGEST_STEP = 1e6  # [s]; no clock of a log ticks slower
Read = Callable[[str, list[str], float | None, bool], list[Piece]]  # file, columns, dt, resample


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run: sampled columns on a uniform clock."""

    name: str
    use: str  # "fit" or "validate"
    controller: str  # id in LogSet.controllers
    columns: Mapping[str, NDArray[np.float64]]
    settings: Mapping[str, Any] = field(default_factory=dict)  # motion, rate_Hz, ...
    file: Path | None = None  # that holds it, None for tables in memory

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
    dt: float  # [s]; the median interval where the clock is uneven
    units: Mapping[str, str]
    remarks: Mapping[str, str]  # text of each column as written, with what follows the unit
    runs: tuple[Run, ...]
    uneven: bool = False  # whether the samples come at uneven times, which are then those of t
    notes: tuple[str, ...] = ()  # what the reader of a diagnosis must know: resampling, stretches

    def sha256(self) -> str:
        """Hash of the description and all tables."""
        digest = hashlib.sha256()
        files = {path for run in self.runs for path in _files(run.file)}
        for path in (*_files(self.folder / FILE), *sorted(files)):
            with open(path, "rb") as stream:
                digest.update(hashlib.file_digest(stream, "sha256").digest())
        for run in self.runs:
            if run.file is None:
                digest.update(run.stack(*run.columns).tobytes())
        return digest.hexdigest()

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
    try:
        description = path / FILE if path.is_dir() else path
        there = description.is_file()
    except PermissionError as error:
        raise InputError(
            path, f"cannot be looked into ({error.strerror})", f"a folder with a file {FILE}"
        ) from None
    if not there:
        raise InputError(
            path,
            "no log set here",
            f"a folder with a file {FILE}",
            "See `gapscope diagnose --help`.",
        )
    return _logset(_read_yaml(description), description, _from_disk(description))


def read_description(path: Path) -> dict[str, Any]:
    """``logset.yaml`` with its keys ``system``, ``controller(s)`` and ``columns`` checked."""
    if not path.is_file():
        raise InputError(path, "file not found", f"a {FILE}")
    document = _read_yaml(path)
    _mapping(document, "system", path)
    _controllers(document, path)
    _units(document, path)
    return {**document, "columns": {str(n): str(text) for n, text in document["columns"].items()}}


def logset_from_frames(
    description: Mapping[str, Any], frames: Mapping[str, Mapping[str, Any]]
) -> LogSet:
    """Log set of tables in memory: pandas DataFrames, or anything with columns by name.

    ``description`` has the keys of ``logset.yaml``; ``file`` of a run is a key of ``frames``. Raises
    InputError as ``load_logset`` does.
    """
    where = Path("description")
    return _logset(_checked(dict(description), where), where, _from_memory(frames))


def _from_disk(description: Path) -> Read:
    def read(file: str, names: list[str], dt: float | None, resample: bool) -> list[Piece]:
        return read_pieces(description.parent / file, names, dt, resample=resample)

    return read


def _from_memory(frames: Mapping[str, Mapping[str, Any]]) -> Read:
    def read(file: str, names: list[str], dt: float | None, resample: bool) -> list[Piece]:
        if file not in frames:
            raise InputError("frames", f"no table {file!r}", f"one of {', '.join(frames)}")
        return read_pieces(Path(file), names, dt, resample=resample, table=frames[file])

    return read


def _logset(document: dict[str, Any], description: Path, read: Read) -> LogSet:
    system = _mapping(document, "system", description)
    kind = MODEL_FILE if "model" in system else system.get("kind")
    if not isinstance(kind, str):
        raise InputError(
            description, f"system.kind is {kind!r}", "the name of a machine, or system.model"
        )
    moves = kind in MOVE_KINDS
    dt = 0.0 if moves else _sample_time(document, description)
    if moves and not {"controller", "controllers"} & document.keys():
        document["controller"] = {"kind": "open_loop"}
    document["columns"] = _columns(document, system, description)
    units = _units(document, description)
    controllers = _controllers(document, description)
    entries = document.get("runs")
    if not isinstance(entries, list) or not entries:
        raise InputError(description, "runs is missing or empty", "a list of runs")
    notes = _remarks(document, description)
    resample = _resample(document, description)
    if resample and moves:
        raise InputError(description, "resample is stated for moves", "no such key")
    if resample and dt is None:
        raise InputError(
            description,
            "`resample` and a sample_time_s that is no number",
            "seconds to resample to",
        )

    def runs_of() -> Iterator[Run]:
        for i, entry in enumerate(entries):
            file, settings = _entry(i, entry, description, controllers)
            for piece in read(file, list(units), dt, resample):
                notes.extend(piece.notes)
                yield _run(piece, settings)

    runs = tuple(runs_of())
    if not any(run.use == "fit" for run in runs):
        raise InputError(description, "no run has use: fit", "at least one run to fit to")
    return LogSet(
        name=str(document.get("name", description.parent.name)),
        folder=description.parent,
        kind=kind,
        system=system,
        controllers=controllers,
        dt=dt or float(np.median(np.concatenate([np.diff(r.columns["t"]) for r in runs]))),
        uneven=dt is None,
        units=units,
        remarks={str(name): str(text) for name, text in document["columns"].items()},
        runs=runs,
        notes=tuple(notes),
    )


def _files(path: Path | None) -> list[Path]:
    """The file, or those of a folder that is one recording."""
    if path is None or not path.exists():
        return []
    return sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]


def _remarks(document: Mapping[str, Any], path: Path) -> list[str]:
    remarks = document.get("remarks", [])
    if not isinstance(remarks, list):
        raise InputError(path, f"remarks is {str(remarks)[:60]!r}", "a list of texts")
    return [str(remark) for remark in remarks]


def _sample_time(document: Mapping[str, Any], path: Path) -> float | None:
    """Sample time [s], or None where the log set refers to its column t instead."""
    dt = document.get("sample_time_s")
    if isinstance(dt, str) and "t column" in dt:
        return None
    if isinstance(dt, bool) or not isinstance(dt, int | float) or not 0.0 < dt < LONGEST_STEP:
        raise InputError(
            path,
            f"sample_time_s is {dt!r}",
            "a positive number of seconds, or a text with 'use the t column' for an uneven clock",
        )
    return float(dt)


def _resample(document: Mapping[str, Any], path: Path) -> bool:
    wanted = document.get("resample")
    if wanted not in (None, "linear"):
        raise InputError(path, f"resample is {wanted!r}", "`resample: linear`, or no such key")
    return wanted is not None


def _read_yaml(path: Path) -> dict[str, Any]:
    try:
        document = read_yaml_mapping(path)
    except ValueError as error:
        where, _, found = str(error).rpartition(": ")
        found, _, expected = found.partition("; expected ")
        raise InputError(where or path, found, expected or "a mapping of keys to values") from None
    return _checked(document, path)


def _checked(document: Any, path: Path) -> dict[str, Any]:
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


def _columns(document: Mapping[str, Any], system: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """The columns as stated, those named with ``JOINT`` once for every one of ``system.joints``."""
    columns = _mapping(document, "columns", path)
    joints = system.get("joints")
    if not any("JOINT" in str(name) for name in columns):
        return columns
    if not isinstance(joints, list) or not all(isinstance(name, str) for name in joints):
        raise InputError(
            path, f"system.joints is {joints!r}", "a list of names that JOINT in columns stands for"
        )
    return {
        str(name).replace("JOINT", joint): text
        for name, text in columns.items()
        for joint in (joints if "JOINT" in str(name) else [""])
    }


def _units(document: Mapping[str, Any], path: Path) -> dict[str, str]:
    columns = _mapping(document, "columns", path)
    if "t" not in columns:
        raise InputError(path, "columns has no t", "a time column `t: s`")
    units = {str(name): bare_unit(str(text)) for name, text in columns.items()}
    if units["t"] != "s":
        raise InputError(
            path, f"columns.t has the unit {units['t']!r}", "seconds, `t: s`", "Convert the times."
        )
    return units


def bare_unit(text: str) -> str:
    """The unit of a column's text: ``rad, 13-bit encoder`` and ``N = 35.15*u`` carry a remark, too."""
    return re.split("[,=]", text)[0].strip()


def _controllers(document: Mapping[str, Any], path: Path) -> dict[str, dict[str, Any]]:
    if "controllers" in document:
        controllers = _mapping(document, "controllers", path)
        for name, value in controllers.items():
            if not isinstance(value, dict):
                raise InputError(path, f"controllers.{name} is {value!r}", "a mapping of settings")
        return {str(name): value for name, value in controllers.items()}
    return {"controller": _mapping(document, "controller", path)}


def _entry(
    i: int, entry: Any, path: Path, controllers: Mapping[str, Any]
) -> tuple[str, dict[str, Any]]:
    """File and settings of an entry of ``runs``, with use and controller filled in."""
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
    return entry["file"], {**entry, "use": use, "controller": controller}


def _run(piece: Piece, entry: Mapping[str, Any]) -> Run:
    settings = {k: v for k, v in entry.items() if k not in ("file", "use", "controller")}
    if piece.begins:
        start = settings.get("start_s", 0.0)
        if isinstance(start, int | float):  # another value is refused by the machine's reader
            settings["start_s"] = start + piece.begins
    return Run(
        name=f"{entry['file']}{piece.label}",
        use=entry["use"],
        controller=entry["controller"],
        columns=piece.columns,
        settings=settings,
        file=piece.file,
    )
