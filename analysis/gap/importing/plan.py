"""What an import would do: which column of the files becomes which column of the log set, and how sure."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from ..description import bare_unit
from ..sampling import JITTER_LIMIT, jitter
from ..tables import Array, Signals, read
from .guess import SURE, Guess, Source, assign, guess_columns, time_of
from .units import factor


@dataclass(frozen=True, kw_only=True)
class Plan:
    """Guesses for all files of an import, made on the first of them."""

    path: Path
    groups: tuple[Signals, ...]
    time: Guess | None  # None: rows are counted with a stated rate
    guesses: tuple[Guess, ...]  # of every column
    columns: Mapping[str, Guess]  # by name in the log set
    texts: Mapping[str, str]  # unit and remark of each column in the log set
    missing: tuple[str, ...]  # columns nothing was found for

    @property
    def doubts(self) -> list[str]:
        """What is not sure enough to be taken without asking, in words."""
        taken = {"t": self.time, **self.columns} if self.time else dict(self.columns)
        return [f"{n} from {g.source} ({g.why})" for n, g in taken.items() if g and g.sure < SURE]

    def require_all(self) -> None:
        """InputError names the columns nothing was found for, and those that are left for them."""
        if self.missing:
            taken = {guess.source for guess in self.columns.values()}
            left = ", ".join(str(g.source) for g in self.guesses if g.source not in taken)[:400]
            raise InputError(
                self.path, f"nothing that would be {', '.join(self.missing)}",
                f"a column for each{f', of {left}' if left else ''}",
                f"State it: --column {self.missing[0]}=COLUMN[:UNIT]",
            )  # fmt: skip

    def state(self, name: str, source: str, unit: str = "") -> "Plan":
        """The plan with one column stated by the user; ``t`` is the time."""
        guess = stated(self, source, unit)
        if name == "t":
            check_increasing(self, guess)
            rest = {n: g for n, g in self.columns.items() if g.source != guess.source}
            return replace(
                self, time=replace(guess, role="time", unit=guess.unit or "s"), columns=rest
            )
        texts = {**self.texts, name: self.texts.get(name) or guess.unit or "unstated"}
        missing = tuple(m for m in self.missing if m != name)
        return replace(self, columns={**self.columns, name: guess}, texts=texts, missing=missing)


def make_plan(path: Path, wanted: Mapping[str, str] | None, rate: float | None = None) -> Plan:
    """Guess what a file holds.

    ``wanted`` are the columns of the log set with their units, ``t`` left out; without them every
    column keeps its name. ``rate`` [Hz] replaces a time column. Raises InputError without any time.
    """
    groups = tuple(read(path))
    times = {g.name: time_of(g) for g in groups} if rate is None else {}
    guesses: list[Guess] = []
    for group in groups:
        time = times.get(group.name)
        if time or rate is not None:
            guesses.extend(guess_columns(group, time.source if time else None))
    time = next((t for t in times.values() if t), None)
    if time is None and rate is None:
        raise InputError(
            path, "no column of increasing times", "times", "State the sample rate: --rate HZ"
        )
    if wanted is None:
        first = [g for g in guesses if g.source.group == groups[0].name or len(groups) == 1]
        columns = {_plain(g.source.column): g for g in first}
        texts = {n: g.unit or "unstated" for n, g in columns.items()}
        missing: list[str] = []
    else:
        columns, missing = assign(guesses, {n: bare_unit(text) for n, text in wanted.items()})
        texts = dict(wanted)
    plan = Plan(
        path=path, groups=groups, time=time, guesses=tuple(guesses), columns=columns,
        texts=texts, missing=tuple(missing),
    )  # fmt: skip
    return _with_clock_of_columns(plan, times)


def _with_clock_of_columns(plan: Plan, times: Mapping[str, Guess | None]) -> Plan:
    """The time is that of the group most of the columns come from."""
    owners = [g.source.group for g in plan.columns.values()]
    best = max(set(owners), key=owners.count) if owners else None
    return replace(plan, time=times.get(best) or plan.time) if best is not None else plan


def _plain(name: str) -> str:
    """A column name without signs that would need quoting in a table's header."""
    return "".join(c if c.isalnum() or c in "_.[]/" else "_" for c in name).strip("_") or "column"


def stated(plan: Plan, source: str, unit: str) -> Guess:
    """The guess for a column the user names, as COLUMN or GROUP:COLUMN."""
    known = [Source(g.name, c) for g in plan.groups for c in g.columns]
    fits = [s for s in known if source in (str(s), s.column)]
    if not fits:
        raise InputError(
            plan.path, f"no column {source!r}", f"one of {', '.join(map(str, known))[:400]}"
        )
    if len(fits) > 1:
        raise InputError(
            plan.path,
            f"{len(fits)} columns {source!r}",
            f"one of {', '.join(map(str, fits))[:400]}",
        )
    guessed = next((g for g in plan.guesses if g.source == fits[0]), None)
    unit = unit or (guessed.unit if guessed else "")
    role = guessed.role if guessed else "other"
    return Guess(source=fits[0], role=role, unit=unit, sure=1.0, why="stated")


def check_increasing(plan: Plan, guess: Guess) -> None:
    """InputError where the stated times do not increase."""
    t = values(plan.path, plan.groups, guess.source)
    backward = np.flatnonzero(~(np.diff(t) > 0.0))
    if backward.size:
        raise InputError(
            f"{plan.path}, row {backward[0] + 3}, column {guess.source}", "time does not increase",
            "times that increase",
        )  # fmt: skip


def values(path: Path, groups: Sequence[Signals], source: Source) -> Array:
    """The column of a file; InputError where it lacks it."""
    for group in groups:
        if group.name == source.group and source.column in group.columns:
            return group.columns[source.column]
    raise InputError(path, f"no column {str(source)!r}", "the columns of the first file")


def scale(name: str, guess: Guess, text: str) -> float:
    """Factor from the unit of the log to that of the log set; unknown units are taken as they are."""
    target = bare_unit(text)
    if not guess.unit or target == "unstated":
        return 1.0
    found = factor(guess.unit, target)
    if found is None:
        raise InputError(
            f"column {name}", f"{guess.source} is in {guess.unit}", target,
            f"If the log is in {target}, say so: --column {name}={guess.source}:{target}",
        )  # fmt: skip
    return found


def controller_of_runs(
    system: Mapping[str, Any], paths: Sequence[Path], stated: Sequence[str]
) -> dict[Path, str]:
    """Which of several ``controllers`` each file was recorded under; empty where there is one.

    ``stated`` holds ID for every file or FILE=ID for one. Raises InputError where a file has none.
    """
    known = [str(name) for name in system.get("controllers", ())]
    if not known and not stated:
        return {}
    found: dict[Path, str] = {}
    for text in sorted(stated, key=lambda text: "=" in text):  # those of one file come last
        file, _, name = text.rpartition("=")
        if name not in known:
            raise InputError("--controller", repr(name), _one_of(known, "controllers of the model"))
        meant = [path for path in paths if not file or file in (str(path), path.name)]
        if not meant:
            raise InputError("--controller", repr(file), _one_of(map(str, paths), "files"))
        found.update(dict.fromkeys(meant, name))
    bare = [path for path in paths if path not in found]
    if len(known) == 1:
        return {**dict.fromkeys(bare, known[0]), **found}
    if bare:
        raise InputError(
            bare[0], "no controller is stated", f"which of {', '.join(known)} it was recorded under",
            f"State it: --controller {known[0]} for every file, --controller {bare[0].name}={known[0]} for one.",
        )  # fmt: skip
    return found


def _one_of(names: Iterable[str], what: str) -> str:
    text = ", ".join(names)
    return f"one of {text}" if text else f"none: it has no {what}"


def description(model: Mapping[str, Any] | None, kind: str | None) -> dict[str, Any]:
    """The keys ``system`` and ``controller(s)`` of the log set, as far as they are known."""
    if model is None:
        return {
            "system": {"kind": kind or "unstated", "nominal": {}},
            "controller": {"kind": "unstated"},
        }
    keys = ("system", "controllers") if "controllers" in model else ("system", "controller")
    return {key: model[key] for key in keys}


def clock_trouble(plan: Plan) -> str:
    """Why the columns need interpolation, empty if they do not."""
    if len({guess.source.group for guess in plan.columns.values()}) > 1:
        return "The columns come from several clocks."
    if plan.time is None:
        return ""
    t = values(plan.path, plan.groups, plan.time.source) * (factor(plan.time.unit, "s") or 1.0)
    found = jitter(t)
    uneven = (
        max(found.longest - found.mean, found.mean - found.shortest) > JITTER_LIMIT * found.mean
    )
    return f"The clock is uneven: {found}." if uneven else ""
