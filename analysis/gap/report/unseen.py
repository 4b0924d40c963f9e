"""What the data could not have shown, and what the diagnosis rests on."""

from typing import Any

from .base import Material, Section
from .words import number


def context(material: Material) -> dict[str, Any]:
    """Warnings, effects that were not tried, and what is left above the floor."""
    d = material.diagnosis
    tried = {effect for r in d.ranking for effect in r.fit.hypothesis.ids}
    s, unit = d.shrinkage, d.machine.effort_unit
    left = ""
    if s.after > 1.05 * s.floor:
        left = (
            f"{number(s.after, unit)} rms stay unexplained on the held-out runs, "
            f"{number(s.after / s.floor)} times the floor."
        )
    return {
        "warnings": d.warnings,
        "untried": sorted(set(d.machine.catalogue()) - tried),
        "left": left,
        "floor_source": s.floor_source,
        "tolerances": [
            f"{p.name} {number(p.lower)} to {number(p.upper, p.unit)}" for p in d.machine.own
        ],
    }


SECTION = Section(key="unseen", title="What could not be seen", context=context)
