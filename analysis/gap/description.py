"""``logset.yaml``: what a log set says of itself, checked key by key before any table is read.

The key ``answer`` of labelled sets is dropped unread; an entry of ``runs`` must not have one.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...models.yaml_mapping import read_yaml_mapping
from ..errors import InputError
from .checks import as_float, refuse_unknown, shown

FILE = "logset.yaml"
TOP_KEYS = frozenset({
    "format", "name", "source", "license", "note", "system", "controller", "controllers",
    "sample_time_s", "columns", "resample", "remarks", "runs", "published",
})  # fmt: skip
MODEL_FILE = "model_file"  # kind of a machine described by an URDF or SDF file
MOVE_KINDS = frozenset(["mm3a"])  # machines whose samples are moves, one after the other
LONGEST_STEP = 1e6  # [s]; no clock of a log ticks slower
OF_AN_ENTRY = ("file", "use", "controller")  # keys of a run that are not settings of it


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One of ``runs``: where its table is, what it is for, and what else is said of it."""

    where: str  # in the log set, for messages
    file: str
    use: str  # "fit" or "validate"
    controller: str
    settings: Mapping[str, Any]


@dataclass(frozen=True, kw_only=True)
class Description:
    """A checked ``logset.yaml``."""

    name: str
    path: Path
    kind: str
    system: Mapping[str, Any]
    controllers: Mapping[str, Mapping[str, Any]]
    dt: float | None  # [s]; None for an uneven clock, 0 for moves, which follow none
    resample: bool
    units: Mapping[str, str]
    texts: Mapping[str, str]  # of each column as written, with what follows the unit
    notes: tuple[str, ...]
    entries: tuple[Entry, ...]


def read_yaml(path: Path) -> dict[str, Any]:
    """The document in a file; InputError unless it is a mapping of known keys in format 1."""
    try:
        document = read_yaml_mapping(path)
    except ValueError as error:
        where, _, found = str(error).rpartition(": ")
        found, _, expected = found.partition("; expected ")
        raise InputError(where or path, found, expected or "a mapping of keys to values") from None
    return known_keys(document, path)


def read_description(path: Path) -> dict[str, Any]:
    """``logset.yaml`` with its keys ``system``, ``controller(s)`` and ``columns`` checked."""
    if not path.is_file():
        raise InputError(path, "file not found", f"a {FILE}")
    document = read_yaml(path)
    _mapping(document, "system", path)
    _controllers(document, path)
    _units(document, path)
    return {**document, "columns": {str(n): str(text) for n, text in document["columns"].items()}}


def known_keys(document: Any, path: Path) -> dict[str, Any]:
    """The document without ``answer``; InputError for an unknown key or another format."""
    if not isinstance(document, dict):
        raise InputError(path, "no keys", "a mapping of keys to values")
    document.pop("answer", None)
    refuse_unknown(path, document, TOP_KEYS)
    if document.get("format") != 1:
        raise InputError(path, f"format is {shown(document.get('format'))}", "format: 1")
    return document


def described(document: Mapping[str, Any], path: Path) -> Description:
    """What a document with known keys says; InputError for whatever cannot be used."""
    system = _mapping(document, "system", path)
    kind = MODEL_FILE if "model" in system else system.get("kind")
    if not isinstance(kind, str):
        raise InputError(
            path, f"system.kind is {shown(kind)}", "the name of a machine, or system.model"
        )
    moves = kind in MOVE_KINDS
    dt = 0.0 if moves else _sample_time(document, path)
    if moves and not {"controller", "controllers"} & document.keys():
        document = {**document, "controller": {"kind": "open_loop"}}
    columns = _columns(document, system, path)
    controllers = _controllers(document, path)
    return Description(
        name=str(document.get("name", path.parent.name)),
        path=path,
        kind=kind,
        system=system,
        controllers=controllers,
        dt=dt,
        resample=_resample(document, path, dt),
        units=_units({"columns": columns}, path),
        texts={str(name): str(text) for name, text in columns.items()},
        notes=tuple(_remarks(document, path)),
        entries=_entries(document, path, controllers),
    )


def bare_unit(text: str) -> str:
    """The unit of a column's text: ``rad, 13-bit encoder`` and ``N = 35.15*u`` carry a remark, too."""
    return re.split("[,=]", text)[0].strip()


def _mapping(document: Mapping[str, Any], key: str, path: Path) -> dict[str, Any]:
    value = document.get(key)
    if not isinstance(value, dict):
        raise InputError(path, f"{key} is missing or not a mapping", f"{key}: with keys of its own")
    return value


def _remarks(document: Mapping[str, Any], path: Path) -> list[str]:
    remarks = document.get("remarks", [])
    if not isinstance(remarks, list):
        raise InputError(path, f"remarks is {shown(remarks)}", "a list of texts")
    return [str(remark) for remark in remarks]


def _sample_time(document: Mapping[str, Any], path: Path) -> float | None:
    """Sample time [s], or None where the log set refers to its column t instead."""
    dt = document.get("sample_time_s")
    if isinstance(dt, str) and "t column" in dt:
        return None
    if not 0.0 < as_float(dt) < LONGEST_STEP:
        raise InputError(
            path,
            f"sample_time_s is {shown(dt)}",
            "a positive number of seconds, or a text with 'use the t column' for an uneven clock",
        )
    return as_float(dt)


def _resample(document: Mapping[str, Any], path: Path, dt: float | None) -> bool:
    wanted = document.get("resample")
    if wanted is None:
        return False
    if wanted != "linear":
        raise InputError(path, f"resample is {shown(wanted)}", "`resample: linear`, or no such key")
    if dt == 0.0:
        raise InputError(path, "resample is stated for moves", "no such key")
    if dt is None:
        raise InputError(
            path, "`resample` and a sample_time_s that is no number", "seconds to resample to"
        )
    return True


def _columns(document: Mapping[str, Any], system: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """The columns as stated, those named with ``JOINT`` once for every one of ``system.joints``."""
    columns = _mapping(document, "columns", path)
    joints = system.get("joints")
    if not any("JOINT" in str(name) for name in columns):
        return columns
    if not isinstance(joints, list) or not all(isinstance(name, str) for name in joints):
        raise InputError(
            path,
            f"system.joints is {shown(joints)}",
            "a list of names that JOINT in columns stands for",
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


def _controllers(document: Mapping[str, Any], path: Path) -> dict[str, dict[str, Any]]:
    if "controllers" not in document:
        return {"controller": _mapping(document, "controller", path)}
    if "controller" in document:
        raise InputError(path, "controller and controllers", "one of both")
    controllers = _mapping(document, "controllers", path)
    if not controllers:
        raise InputError(
            path, "controllers is empty", "`controllers: {ID: {kind: ...}}`, or one `controller`"
        )
    for name, value in controllers.items():
        if not isinstance(value, dict):
            raise InputError(path, f"controllers.{name} is {shown(value)}", "a mapping of settings")
    return {str(name): value for name, value in controllers.items()}


def _entries(
    document: Mapping[str, Any], path: Path, controllers: Mapping[str, Any]
) -> tuple[Entry, ...]:
    """The runs as described; each has a table of its own."""
    stated = document.get("runs")
    if not isinstance(stated, list) or not stated:
        raise InputError(path, "runs is missing or empty", "a list of runs")
    entries: list[Entry] = []
    tables: dict[Path, str] = {}
    for i, one in enumerate(stated):
        entry = _entry(f"{path}, runs[{i}]", one, path, controllers)
        table = _table(entry, path)
        if table in tables:
            raise InputError(
                f"{entry.where}.file",
                f"{entry.file!r} is the table of {tables[table]}, too",
                "a table of its own for every run",
            )
        tables[table] = f"runs[{i}]"
        entries.append(entry)
    if not any(entry.use == "fit" for entry in entries):
        raise InputError(path, "no run has use: fit", "at least one run to fit to")
    return tuple(entries)


def _entry(where: str, entry: Any, path: Path, controllers: Mapping[str, Any]) -> Entry:
    if not isinstance(entry, dict) or not isinstance(entry.get("file"), str):
        raise InputError(where, "no file", "`file: NAME.csv`")
    use = entry.get("use")
    if use not in ("fit", "validate"):
        raise InputError(where, f"use is {shown(use)}", "fit or validate")
    controller = str(entry.get("controller", next(iter(controllers))))
    if "controller" not in entry and len(controllers) > 1:
        raise InputError(
            where, "no controller", f"which of {', '.join(sorted(controllers))} the run was recorded under",
            "Add `controller: ID` to the run.",
        )  # fmt: skip
    if controller not in controllers:
        raise InputError(
            where, f"controller is {shown(controller)}", f"one of {', '.join(sorted(controllers))}"
        )
    if "answer" in entry:
        raise InputError(where, "unknown key 'answer'", "a run without it")
    return Entry(
        where=where,
        file=entry["file"],
        use=use,
        controller=controller,
        settings={key: value for key, value in entry.items() if key not in OF_AN_ENTRY},
    )


def _table(entry: Entry, path: Path) -> Path:
    """The file of an entry, inside the folder of the log set."""
    try:
        table = (path.parent / entry.file).resolve()
        inside = table.is_relative_to(path.parent.resolve())
    except (OSError, RuntimeError, ValueError) as error:  # a NUL, a name too long, links in a ring
        raise InputError(
            entry.where, f"file is {shown(entry.file)} ({error})", "the name of a file"
        ) from None
    if not inside:
        raise InputError(
            entry.where, f"file {shown(entry.file)} is outside the log set", "a file in it"
        )
    return table
