"""Log sets: a folder with ``logset.yaml`` and one table per run (format 1).

Where a sample is a move (``MOVE_KINDS``), rows follow no clock and no controller need be stated.

Reading is strict. A file that cannot be used ends in one ``InputError`` that names the file and the
key, column or row, and says what to do. The key ``answer`` of labelled sets is dropped unread.
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from .checks import as_float
from .description import FILE, Description, Entry, described, known_keys, read_yaml
from .sampling import Piece, read_pieces

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
    whole: bool = True  # not a stretch of a longer run

    @property
    def samples(self) -> int:
        """Number of samples."""
        return int(self.columns["t"].size)

    def stack(self, *names: str) -> NDArray[np.float64]:
        """Columns side by side, (samples, len(names)), contiguous."""
        return np.column_stack([self.columns[name] for name in names])

    @property
    def changes(self) -> bool:
        """Whether anything but the time changes: two rests may well be logged alike."""
        return any(np.ptp(column) > 0.0 for name, column in self.columns.items() if name != "t")

    def sha256(self) -> str:
        """Hash of the numbers."""
        return hashlib.sha256(self.stack(*self.columns).tobytes()).hexdigest()


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
    return _logset(described(read_yaml(description), description), _from_disk(description))


def logset_from_frames(
    description: Mapping[str, Any], frames: Mapping[str, Mapping[str, Any]]
) -> LogSet:
    """Log set of tables in memory: pandas DataFrames, or anything with columns by name.

    ``description`` has the keys of ``logset.yaml``; ``file`` of a run is a key of ``frames``. Raises
    InputError as ``load_logset`` does.
    """
    where = Path("description")
    return _logset(described(known_keys(dict(description), where), where), _from_memory(frames))


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


def _logset(given: Description, read: Read) -> LogSet:
    notes = list(given.notes)

    def runs_of() -> Iterator[Run]:
        for entry in given.entries:
            for piece in read(entry.file, list(given.units), given.dt, given.resample):
                notes.extend(piece.notes)
                yield _run(piece, entry)

    runs = tuple(runs_of())
    _refuse_copies(given.path, runs)
    return LogSet(
        name=given.name,
        folder=given.path.parent,
        kind=given.kind,
        system=given.system,
        controllers=given.controllers,
        dt=given.dt or float(np.median(np.concatenate([np.diff(r.columns["t"]) for r in runs]))),
        uneven=given.dt is None,
        units=given.units,
        remarks=given.texts,
        runs=runs,
        notes=tuple(notes),
    )


def _refuse_copies(path: Path, runs: Sequence[Run]) -> None:
    """Refuse a table that is fitted to and held out: what it shows of a model is no test."""
    fitted = {run.sha256(): run.name for run in runs if run.use == "fit"}
    for run in runs:
        if run.use == "validate" and run.changes and run.sha256() in fitted:
            raise InputError(
                f"{path}, runs[{run.name}]",
                f"its numbers are those of {fitted[run.sha256()]}, which is fitted to",
                "a validation run of its own",
                "Record another run. Where no run is marked validate, the end of every run or "
                "some whole runs are held back.",
            )


def _files(path: Path | None) -> list[Path]:
    """The file, or those of a folder that is one recording."""
    if path is None or not path.exists():
        return []
    return sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]


def _run(piece: Piece, entry: Entry) -> Run:
    settings = dict(entry.settings)
    start = as_float(settings.get("start_s", 0.0))
    if piece.begins and np.isfinite(start):  # another value is refused by the machine's reader
        settings["start_s"] = start + piece.begins
    return Run(
        name=f"{entry.file}{piece.label}",
        use=entry.use,
        controller=entry.controller,
        columns=piece.columns,
        settings=settings,
        file=piece.file,
        whole=not piece.label,
    )
