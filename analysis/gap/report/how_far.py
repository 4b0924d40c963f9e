"""How far the gap shrinks on held-out runs: before, retuned, after and the floor."""

from typing import Any

from ..shrinkage import Shrinkage
from .base import Material, Section, rms
from .words import digits_of, interval, number, percent


def context(material: Material) -> dict[str, Any]:
    """The four numbers, the closed-loop table and the same run by run."""
    d = material.diagnosis
    s, unit = d.shrinkage, d.machine.effort_unit
    models = (
        ("before", "before: nominal model"),
        ("retuned", "retuned inside its tolerance"),
        (
            "after",
            f"after: {'with the accepted effects' if d.verdict.accepted else 'the diagnosis'}",
        ),
    )
    rows = [_row(key, label, s, unit) for key, label in (*models, ("floor", "noise floor"))]
    return {
        "metric": s.metric,
        "rows": rows,
        "percent": None if s.percent is None else f"{s.percent:.1f}",
        "ci95": None if s.ci95 is None else f"{s.ci95[0]:.1f} to {s.ci95[1]:.1f}",
        "floor_source": s.floor_source,
        "floor_measured": s.intervals["floor"] is not None,
        "below_floor": s.after < s.floor,
        "loops": [_loop(label, d.closed_loop.get(key), d.machine.position_unit)
                  for key, label in models],
        "position_unit": d.machine.position_unit,
        "runs": _by_run(material, unit),
        "corrected": bool(d.findings),
    }  # fmt: skip


def _row(key: str, label: str, s: Shrinkage, unit: str) -> dict[str, str]:
    """A level in the unit of the effort, its interval, and as a share of the command."""
    value, ends, command = getattr(s, key), s.intervals[key], s.relative_to_command
    share = value / command if command > 0.0 else None
    digits = 3 if ends is None else digits_of(value, 0.5 * (ends[1] - ends[0]))
    return {
        "label": label,
        "value": number(value, unit, digits),
        "interval": "–" if ends is None else interval(ends, unit),
        "relative": percent(share, 1),
    }


def _loop(label: str, result: dict[str, float] | None, unit: str) -> dict[str, str]:
    if result is None:
        return {"label": label, "command": "diverges", "position": "diverges"}
    return {
        "label": label,
        "command": percent(result["relative_command_error"], 1),
        "position": number(result[f"position_error_{unit}"], unit),
    }


def _by_run(material: Material, unit: str) -> list[dict[str, Any]]:
    d = material.diagnosis
    kinds = [material.efforts(fit) for fit in (d.nominal, d.retuned, d.chosen)]
    return [
        {"name": run.name, "values": [number(rms(kind[i]), unit) for kind in kinds]}
        for i, run in enumerate(material.held_out)
    ]


SECTION = Section(key="how_far", title="How far it shrinks", context=context)
