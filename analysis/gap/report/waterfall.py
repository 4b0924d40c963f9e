"""From the nominal model to the floor: what every step takes off the unexplained effort."""

from itertools import pairwise
from typing import Any

from ..hypothesis import Fit
from .base import Material, Section
from .words import number


def context(material: Material) -> dict[str, Any]:
    """Bars of a waterfall on the held-out runs, in rms unexplained effort."""
    d = material.diagnosis
    unit = d.machine.effort_unit
    levels = [
        ("nominal model, signals as logged" if d.findings else "nominal model", d.shrinkage.before)
    ]
    if d.findings:
        names = ", ".join(f.effect for f in d.findings)
        levels.append((f"{names} corrected in the log", material.rms(d.nominal)))
    levels.append(("retuned inside its tolerance", d.shrinkage.retuned))
    levels += [(f"+ {label}", material.rms(fit)) for label, fit in _steps(material)]
    top = max(*(value for _, value in levels), d.shrinkage.floor, 1e-300)
    rows = [_total(levels[0], top, unit, "before")]
    for (_, previous), (label, value) in pairwise(levels):
        rows.append(_step(label, previous, value, top, unit))
    rows.append(_total(("left unexplained", levels[-1][1]), top, unit, "after"))
    rows.append(_total(("noise floor", d.shrinkage.floor), top, unit, "floor"))
    return {"rows": rows, "floor": 100.0 * d.shrinkage.floor / top, "unit": unit}


def _steps(material: Material) -> list[tuple[str, Fit]]:
    """Accepted effects one after the other: each time the best fitted part of the accepted set.

    Where a part was not fitted on its own, two effects make one step.
    """
    accepted = material.diagnosis.verdict.accepted
    if accepted is None:
        return []
    whole = set(accepted.fit.hypothesis.ids)
    steps: list[tuple[str, Fit]] = []
    have: set[str] = set()
    while have != whole:
        parts = [
            r
            for r in material.diagnosis.ranking
            if have < set(r.fit.hypothesis.ids) <= whole and r is not accepted
        ]
        least = min((len(r.fit.hypothesis.ids) for r in parts), default=len(whole))
        parts = [r for r in parts if len(r.fit.hypothesis.ids) == least < len(whole)]
        chosen = min(parts, key=lambda r: r.fit.held_out_rms, default=accepted)
        added = [i for i in chosen.fit.hypothesis.ids if i not in have]
        steps.append((" and ".join(added), chosen.fit))
        have = set(chosen.fit.hypothesis.ids)
    return steps


def _total(level: tuple[str, float], top: float, unit: str, kind: str) -> dict[str, Any]:
    label, value = level
    return {
        "label": label, "kind": kind, "x": 0.0, "width": 100.0 * value / top,
        "value": number(value, unit), "change": "",
    }  # fmt: skip


def _step(label: str, previous: float, value: float, top: float, unit: str) -> dict[str, Any]:
    low, high = sorted((previous, value))
    return {
        "label": label,
        "kind": "fall" if value <= previous else "rise",
        "x": 100.0 * low / top,
        "width": 100.0 * (high - low) / top,
        "value": number(value, unit),
        "change": f"{100.0 * (value - previous) / top:+.1f} %".replace("-", "\N{MINUS SIGN}"),
    }


SECTION = Section(key="waterfall", title="What makes up the gap", context=context)
