"""What the columns of a log are: time, units and roles, each with how sure the guess is and why.

Evidence, strongest first: what the format says (a message's stamp, a units row), the name, and the
numbers (times increase; a torque named by nobody cannot be told from a position by its numbers).
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ..tables import Array, Signals
from ..tables.base import TIME_NAME
from .units import UNITS, known_unit

SURE = 0.8  # a guess below this is asked about, or must be confirmed by --yes
REFERENCE, POSITION, VELOCITY, EFFORT = "reference", "position", "velocity", "effort"
PATTERNS = (
    (REFERENCE, r"(^|_)(ref|reference|des|desired|set|setpoint|sp|target|goal|soll)($|_)"),
    (VELOCITY, r"(^|_)(vel|velocity|speed|qd|dq|omega|rate)($|_)"),
    (EFFORT, r"(^|_)(tau|torque|effort|force|trq|moment)($|_)"),
    ("current", r"(^|_)(i|cur|current|amps?)($|_)"),
    ("voltage", r"(^|_)(u|volt|voltage|pwm)($|_)"),
    (POSITION, r"(^|_)(q|x|y|z|pos|position|angle|enc|encoder|psi|theta|phi|ist|act|actual|meas|measured)($|_)"),
)  # fmt: skip
EFFORTS = ("torque", "force")
QUANTITY_ROLES = {
    "angle": POSITION, "length": POSITION, "torque": EFFORT, "force": EFFORT, "rate": VELOCITY,
    "speed": VELOCITY, "voltage": "voltage", "current": "current", "time": "time",
}  # fmt: skip


class Source(NamedTuple):
    """A column of a file."""

    group: str
    column: str

    def __str__(self) -> str:
        return f"{self.group}:{self.column}" if self.group else self.column


@dataclass(frozen=True, kw_only=True)
class Guess:
    """What one column is taken for."""

    source: Source
    role: str  # time, reference, position, velocity, effort, voltage, current, other
    unit: str  # empty where unknown
    sure: float  # 0 to 1
    why: str


def time_of(group: Signals) -> Guess | None:
    """The column of times of a group, with its unit; None if no column increases throughout."""
    for column, sure, why in _time_candidates(group):
        t = group.columns[column]
        if t.size > 1 and np.all(np.diff(t) > 0.0):
            unit, unit_sure, unit_why = _time_unit(column, group, t)
            return Guess(
                source=Source(group.name, column),
                role="time",
                unit=unit,
                sure=min(sure, unit_sure),
                why=f"{why}; {unit_why}",
            )
    return None


def _time_candidates(group: Signals) -> list[tuple[str, float, str]]:
    found = [(group.time, 0.95, "the format says so")] if group.time else []
    for name in group.columns:
        if TIME_NAME.match(re.sub(r"[_ ]?(s|ms|us|ns|sec)$", "", name) or name):
            found.append((name, 0.95, "its name"))
    found.extend((name, 0.6, "it increases throughout") for name in group.columns)
    return found


def _time_unit(name: str, group: Signals, t: Array) -> tuple[str, float, str]:
    stated = _stated_unit(name, group.units)
    if stated and UNITS[stated[0]][0] == "time":
        return stated
    step = float(np.median(np.diff(t)))
    if 1e-5 <= step < 1.0:
        return "s", 0.9, f"steps of {step:.4g} would be seconds"
    if step >= 1e4:
        return "ns", 0.7, f"steps of {step:.4g} would be nanoseconds"
    if step >= 100.0:
        return "us", 0.5, f"steps of {step:.4g} may be microseconds"
    return "ms", 0.5, f"steps of {step:.4g} may be milliseconds"


def _stated_unit(name: str, units: Mapping[str, str]) -> tuple[str, float, str] | None:
    """Unit written with a column: in a units row or brackets, or as the end of its name."""
    text = units.get(name, "")
    if unit := known_unit(text) if text else None:
        return unit, 0.95, f"the file says {text}"
    tail = re.split(r"[_ ]", name)[-1]
    if len(tail) < len(name) and (unit := known_unit(tail)):
        return unit, 0.9, f"the name ends in {tail}"
    return None


def guess_columns(group: Signals, time: Source | None) -> list[Guess]:
    """Role and unit of every column of a group but its time."""
    guesses = [_guess(name, group) for name in group.columns if Source(group.name, name) != time]
    return _tell_reference(group, guesses)


def _guess(name: str, group: Signals) -> Guess:
    role, sure, why = _role(name)
    if role == POSITION and _role(group.name)[0] == REFERENCE:
        role, why = REFERENCE, f"a position of {group.name}"
    stated = _stated_unit(name, group.units)
    unit = stated[0] if stated else ""
    if stated:
        by_unit = QUANTITY_ROLES[UNITS[unit][0]]
        why = f"{why}; {stated[2]}"
        if role == "other":
            role, sure = by_unit, 0.7
        elif by_unit not in (role, POSITION if role == REFERENCE else role):
            role, sure, why = by_unit, 0.5, f"{why}, which is no {role}"
    return Guess(source=Source(group.name, name), role=role, unit=unit, sure=sure, why=why)


def _role(name: str) -> tuple[str, float, str]:
    tokens = re.sub(r"([a-z])([A-Z])", r"\1_\2", name)
    tokens = re.sub(r"[^A-Za-z0-9]+|(?<=[A-Za-z])(?=\d)", "_", tokens).lower()
    for role, pattern in PATTERNS:
        found = re.search(pattern, tokens)
        if found:
            word = found.group(0).strip("_")
            return role, 0.9 if len(word) > 1 else 0.8, f"{word!r} in its name"
    return "other", 0.0, "nothing in its name"


def _tell_reference(group: Signals, guesses: list[Guess]) -> list[Guess]:
    """Where positions have no named reference: of two nearly equal columns of a joint, the earlier is it."""
    if any(g.role == REFERENCE for g in guesses):
        return guesses
    positions = [g for g in guesses if g.role == POSITION]
    for i, first in enumerate(positions):
        for second in positions[i + 1 :]:
            if _joint(first.source.column) != _joint(second.source.column):
                continue
            a, b = (group.columns[g.source.column] for g in (first, second))
            if a.std() and b.std() and np.corrcoef(a, b)[0, 1] > 0.95:
                early, late = (first, second) if _leads(a, b) else (second, first)
                changed = replace(
                    early, role=REFERENCE, sure=0.6,
                    why=f"nearly equal to {late.source.column}, and earlier",
                )  # fmt: skip
                return [changed if g is early else g for g in guesses]
    return guesses


def _leads(a: Array, b: Array) -> bool:
    """Whether ``a`` runs ahead of ``b``: the sign of the mean lag seen in b - a against the rate."""
    return float(np.mean((a - b) * np.gradient(0.5 * (a + b)))) > 0.0


def assign(
    guesses: Sequence[Guess], wanted: Mapping[str, str]
) -> tuple[dict[str, Guess], list[str]]:
    """Columns of a kind of machine (name -> unit) by guesses, and those nothing was found for.

    An equal name wins; otherwise role and quantity must fit, and joints are matched by their token
    (left, L, 1, x ...) or, failing that, by order.
    """
    by_name = {g.source.column: g for g in guesses}
    found = {n: replace(by_name[n], sure=0.9, why="the same name") for n in wanted if n in by_name}
    left = [g for g in guesses if g.source not in {f.source for f in found.values()}]
    for name, unit in wanted.items():
        role = _wanted_role(name, unit)
        fits = [g for g in left if g.role == role and _fits(g.unit, unit)]
        if name in found or not fits:
            continue
        same = [g for g in fits if _joint(g.source.column) == _joint(name)] or fits
        best = max(same, key=lambda g: g.sure)
        found[name] = _with_doubts(best, len(same), unit)
        left.remove(best)
    return found, [name for name in wanted if name not in found]


def _with_doubts(guess: Guess, rivals: int, wanted: str) -> Guess:
    """Less sure where several columns would do, and where the log states no unit."""
    sure, why = guess.sure, guess.why
    if rivals > 1:
        sure, why = min(sure, 0.5), f"{why}; {rivals} columns would do"
    if not guess.unit:
        sure, why = min(sure, 0.7), f"{why}; no unit stated, {wanted} assumed"
    return replace(guess, sure=sure, why=why)


def _wanted_role(name: str, unit: str) -> str:
    by_name = _role(name)[0]
    if by_name == REFERENCE:
        return REFERENCE
    known = known_unit(unit)
    return QUANTITY_ROLES[UNITS[known][0]] if known else by_name


def _fits(unit: str, wanted: str) -> bool:
    a, b = known_unit(unit) if unit else None, known_unit(wanted)
    return a is None or b is None or UNITS[a][0] == UNITS[b][0]


def _joint(name: str) -> str:
    """What tells a joint from its neighbours: l, r, a digit or an axis; empty for the only one."""
    tokens = re.sub(r"[^A-Za-z0-9]+|(?<=[A-Za-z])(?=\d)", "_", name).lower().split("_")
    names = {"left": "l", "right": "r"}
    found = [names.get(t, t) for t in tokens if t in (*"lrxyz", "left", "right") or t.isdigit()]
    return found[-1] if found else ""
