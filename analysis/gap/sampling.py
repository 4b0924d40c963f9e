"""From a table to the runs of a log set: checks of values and clock, resampling, long tables.

Nothing is done silently: what was resampled, how the clock jitters and which stretches of a long table
were taken is said in the notes of each piece, and becomes a warning of the diagnosis.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError
from . import stretches
from .tables import BLOCK, blocks

Array = NDArray[np.float64]

SHORTEST_RUN = 100  # samples; less than this says nothing about a machine
FEWEST_MOVES = 10  # likewise, where a sample is a move
JITTER_LIMIT = 0.1  # largest deviation of a sample from the uniform clock, in sample times
JITTER_TOLD = 0.01  # rms deviation of the intervals that is worth a note, in sample times
WIDEST_GAP = 10.0  # sample times; interpolation over more would invent data


@dataclass(frozen=True, kw_only=True)
class Piece:
    """A run, or a stretch of one that is too long to be read whole."""

    columns: Mapping[str, Array]
    file: Path | None
    notes: tuple[str, ...] = ()
    label: str = ""  # which stretch, empty for a whole run
    begins: float = 0.0  # of the stretch in its run [s]


@dataclass(frozen=True, kw_only=True)
class Jitter:
    """How uneven the intervals of a clock are, all in seconds."""

    mean: float
    shortest: float
    longest: float
    rms: float  # deviation from the mean

    def __str__(self) -> str:
        return (
            f"intervals of {1e3 * self.mean:.6g} ms in the mean, {1e3 * self.shortest:.4g} to "
            f"{1e3 * self.longest:.4g} ms, rms jitter {1e3 * self.rms:.3g} ms"
        )


def jitter(t: Array) -> Jitter:
    """Statistics of the intervals of increasing times (samples,) [s]."""
    steps = np.diff(t)
    return Jitter(
        mean=float(np.mean(steps)),
        shortest=float(np.min(steps)),
        longest=float(np.max(steps)),
        rms=float(np.std(steps)),
    )


def read_pieces(
    path: Path,
    names: Sequence[str],
    dt: float | None,
    *,
    resample: bool = False,
    table: Mapping[str, Any] | None = None,
) -> list[Piece]:
    """The run in the file ``path`` (or the ``table`` of that name), whole or as stretches if it is long.

    ``names`` are its columns, ``t`` [s] among them; ``dt`` [s] the stated interval, None for samples
    that come at uneven times and stay there, 0 for moves, which follow no clock. Memory is bounded
    by ``stretches.LONGEST`` rows. Raises InputError that names row and column.
    """
    parts, longer = [], False
    stream = _stream(path, names, table)
    rows = 0
    for block in stream:
        parts.append(block)
        rows += len(block)
        if rows > stretches.LONGEST:
            longer = True
            break
    file = path if table is None else None
    if longer:
        if not dt:
            raise InputError(
                path, f"more than {stretches.LONGEST} rows at uneven times", "a shorter log",
                "Cut the log into shorter runs.",
            )  # fmt: skip
        return _stretches(path, names, dt, file, itertools.chain(parts, stream), table, resample)
    values = np.concatenate(parts) if parts else np.empty((0, len(names)))
    fewest = FEWEST_MOVES if dt == 0.0 else SHORTEST_RUN
    if len(values) < fewest:
        raise InputError(
            path, f"{len(values)} rows of {values.shape[1]} numbers", f"at least {fewest} rows"
        )
    columns = {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(names)}
    _check_finite(path, columns)
    columns, notes = _on_clock(path, columns, dt, resample)
    return [Piece(columns=columns, file=file, notes=notes)]


def _stream(path: Path, names: Sequence[str], table: Mapping[str, Any] | None) -> Iterator[Array]:
    if table is None:
        return blocks(path, names)
    known = [str(name) for name in getattr(table, "columns", table)]
    missing = [name for name in names if name not in known]
    if missing:
        raise InputError(path, f"no column {missing[0]!r}", ", ".join(names), f"It has {known}.")
    try:
        columns = [np.asarray(table[name], dtype=np.float64) for name in names]
        whole = np.column_stack(columns)
    except (TypeError, ValueError) as error:
        raise InputError(path, str(error), "columns of numbers of equal length") from None
    return (whole[i : i + BLOCK] for i in range(0, len(whole), BLOCK))


def _check_finite(path: Path, columns: Mapping[str, Array]) -> None:
    for name, column in columns.items():
        bad = np.flatnonzero(~np.isfinite(column))
        if bad.size:
            raise InputError(
                f"{path}, row {bad[0] + 2}, column {name}",
                f"{column[bad[0]]} ({bad.size} such values)",
                "a finite number",
                "Cut the run or fill the gap before diagnosing.",
            )


def _on_clock(
    path: Path, columns: dict[str, Array], dt: float | None, resample: bool
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """The columns on a uniform clock, and what is to be said of it."""
    t = columns["t"]
    steps = np.diff(t)
    backward = np.flatnonzero(steps <= 0.0)
    if backward.size:
        row = int(backward[0])
        raise InputError(
            f"{path}, row {row + 3}, column t",
            f"time goes from {t[row]:g} to {t[row + 1]:g} s",
            "times that increase",
        )
    if dt == 0.0:
        return columns, ()
    found = jitter(t)
    if dt is None:
        return columns, (f"{path.name}: {found}; uneven, the logged times are used.",)
    # A clock that is off by less than is refused below drifts in a long run, but does not jitter.
    clock = found.mean if abs(found.mean - dt) <= 1e-3 * dt else dt
    worst = float(np.max(np.abs(t - (t[0] + clock * np.arange(t.size)))))
    uneven = worst > JITTER_LIMIT * dt or np.max(np.abs(steps - dt)) > JITTER_LIMIT * dt
    if uneven and resample:
        return resampled(path, columns, dt)
    if abs(found.mean - dt) > 1e-3 * dt:
        raise InputError(
            f"{path}, column t",
            f"the mean interval is {found.mean:g} s",
            f"sample_time_s = {dt:g} s",
        )
    if uneven:
        row = int(np.argmax(np.abs(steps - dt)))
        raise InputError(
            f"{path}, row {row + 3}, column t",
            f"the clock jitters by up to {worst:g} s",
            f"uniform steps of {dt:g} s within {100 * JITTER_LIMIT:.0f} %",
            "State `resample: linear` in logset.yaml to have it brought to a uniform clock.",
        )
    if found.rms > JITTER_TOLD * dt:
        return columns, (f"{path.name}: {found}; taken as uniform.",)
    return columns, ()


def resampled(
    path: Path, columns: Mapping[str, Array], dt: float
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Columns interpolated linearly to a uniform clock of ``dt`` [s], and the note that says so."""
    t = columns["t"]
    found = jitter(t)
    if found.longest > WIDEST_GAP * max(dt, float(np.median(np.diff(t)))):
        row = int(np.argmax(np.diff(t)))
        raise InputError(
            f"{path}, row {row + 3}, column t",
            f"{found.longest:g} s without a sample",
            f"no gap above {WIDEST_GAP:g} sample times",
            "Cut the run there: interpolation would invent data.",
        )
    samples = (t[-1] - t[0]) / dt
    if samples > 2.0 * WIDEST_GAP * t.size:
        raise InputError(
            path,
            f"{samples:.3g} samples of {dt:g} s from {t.size} rows",
            "a sample time of the log",
        )
    even = t[0] + dt * np.arange(int(samples * (1.0 + 1e-12)) + 1)
    note = (
        f"{path.name}: {t.size} samples with {found} were resampled to {even.size} samples of "
        f"{1e3 * dt:g} ms by linear interpolation, which smooths what is faster than a few samples."
    )
    if dt > 1.5 * found.mean:
        note += " It was NOT low-pass filtered: content above the new Nyquist frequency is folded."
    new = {name: np.interp(even, t, column) for name, column in columns.items()}
    return {**new, "t": even}, (note,)


def _stretches(
    path: Path,
    names: Sequence[str],
    dt: float,
    file: Path | None,
    stream: Iterator[Array],
    table: Mapping[str, Any] | None,
    resample: bool,
) -> list[Piece]:
    if resample:
        raise InputError(
            path, f"more than {stretches.LONGEST} rows and `resample`", "one of both",
            "Cut the log into shorter runs, or drop `resample` to have even stretches chosen.",
        )  # fmt: skip
    clock = list(names).index("t")
    survey = stretches.survey(stream, clock, dt, JITTER_LIMIT)
    chosen = stretches.choose(survey)
    if not chosen:
        raise InputError(
            f"{path}, column t",
            f"no {stretches.LENGTH} rows without a gap or an uneven clock",
            f"uniform steps of {dt:g} s within {100 * JITTER_LIMIT:.0f} % and finite numbers",
        )
    note = f"{path.name}: {survey.describe(chosen)}"
    pieces: list[Piece] = []
    for values in stretches.collect(_stream(path, names, table), chosen):
        t = values[:, clock]
        columns = {name: np.ascontiguousarray(values[:, i]) for i, name in enumerate(names)}
        pieces.append(
            Piece(
                columns=columns,
                file=file,
                label=f"[{t[0]:.6g}-{t[-1]:.6g} s]",
                begins=float(t[0] - survey.first),
                notes=() if pieces else (note,),
            )
        )
    return pieces
