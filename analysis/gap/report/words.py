"""Numbers, effects and confidence in words."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from ..machine import Machine
from ..ranking import Ranked

MINUS = "\N{MINUS SIGN}"
CONFIDENCE = ((0.99, "very high"), (0.9, "high"), (0.7, "moderate"), (0.0, "low"))
DIMENSIONLESS = ("", "-", "1")


def number(value: float | None, unit: str = "", digits: int = 3) -> str:
    """A number with significant digits and its unit, such as ``1.2 × 10⁻⁵ N m``."""
    if value is None or not math.isfinite(value):
        return "–"
    text = f"{value:#.{digits}g}".rstrip(".")
    if "e" in text:
        mantissa, exponent = text.split("e")
        raised = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        text = f"{mantissa.rstrip('.')} × 10{raised}"
    text = text.replace("-", MINUS)
    return text if unit in DIMENSIONLESS else f"{text}\N{NO-BREAK SPACE}{unit.replace('^2', '²')}"


def percent(share: float | None, digits: int = 0) -> str:
    """A share as per cent; what is not quite nothing or all does not round to it."""
    if share is None or not math.isfinite(share):
        return "–"
    least = 10.0**-digits
    value = 100.0 * share
    if 0.0 < value < 0.5 * least:
        text = f"<{least:g}"
    elif 100.0 - 0.5 * least < value < 100.0:
        text = f">{100.0 - least:g}"
    else:
        text = f"{value:.{digits}f}"
    return f"{text.replace('-', MINUS)}\N{NO-BREAK SPACE}%"


def interval(ends: Sequence[float], unit: str = "") -> str:
    """``low to high`` with as many digits as tell the two apart."""
    low, high = ends
    width = high - low
    if not (math.isfinite(low) and math.isfinite(high)):
        return "–"
    size = max(abs(low), abs(high))
    digits = 3 if width <= 0.0 else _digits(size / width)
    return f"{number(low, digits=digits)} to {number(high, unit, digits)}"


def digits_of(value: float, half_width: float) -> int:
    """Significant digits of a value known to +- ``half_width``."""
    if not half_width > 0.0 or value == 0.0:  # not known: NaN
        return 3
    return _digits(abs(value) / half_width)


def _digits(ratio: float) -> int:
    return min(6, max(3, 1 + math.ceil(math.log10(max(ratio, 1.0)))))


def listed(items: Iterable[str], joint: str = "and") -> str:
    """``a, b and c``."""
    names = list(items)
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} {joint} {names[-1]}"


def meaning(effect: str, machine: Machine) -> str:
    """What an effect id stands for, in a few words; empty for an id outside the catalogue."""
    known = machine.catalogue().get(effect)
    return known.summary.split(";")[0] if known else ""


def signature(effect: str, machine: Machine) -> str:
    """What the unexplained effort of a machine with the effect looks like."""
    known = machine.catalogue().get(effect)
    return known.signature if known else ""


def place(where: Mapping[str, Any], machine: Machine) -> str:
    """Where an effect acts, such as ``left``; empty on a machine with one place only."""
    if len(machine.places) == 1:
        return ""
    parts = []
    for value in where.values():
        names = [str(v) for v in value] if isinstance(value, list | tuple) else [str(value)]
        if len(names) > 1 and set(names) >= set(machine.places):
            parts.append(
                f"all {len(names)} of {listed(names)}"
                if len(names) > 2
                else f"both {listed(names)}"
            )
        else:
            parts.append(listed(names))
    return "; ".join(part for part in parts if part)


def places(ranked: Ranked, effect: str, machine: Machine) -> str:
    """Where a hypothesis says that its effect acts."""
    hypothesis = ranked.fit.hypothesis
    form = next(f for f in hypothesis.forms if f.effect == effect)
    return place(form.where([p.name for p in hypothesis.kept(form)]), machine)


def confidence(probability: float) -> str:
    """A word for a probability."""
    return next(word for least, word in CONFIDENCE if probability >= least)
