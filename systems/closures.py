"""Loop closures kept beside an SDF, applied to a plant before it is finalised.

A closures file is a YAML list of ``{type: weld | ball, body_a, body_b, p_a, p_b}``: the bodies' names and,
optionally, where on them the closure sits [m, in the body's frame]. Welded frames stay parallel to their bodies.
"""

from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import ModelInstanceIndex

from ..models.closure import Closure

__all__ = ["Closure", "apply", "load"]


def load(path: Path) -> list[Closure]:
    """Closures of a file; ValueError for an unknown key or type."""
    entries: list[dict[str, Any]] = yaml.safe_load(path.read_text()) or []
    known = set(Closure.__dataclass_fields__)
    for entry in entries:
        unknown = sorted(set(entry) - known)
        if unknown:
            raise ValueError(f"{path}: unknown key {unknown[0]!r}; expected {sorted(known)}")
    return [
        Closure(**{key: tuple(v) if isinstance(v, list) else v for key, v in entry.items()})
        for entry in entries
    ]


def apply(plant: MultibodyPlant, model: ModelInstanceIndex, closures: list[Closure]) -> None:
    """Add the closures as constraints of a discrete SAP plant that is not finalised yet."""
    for closure in closures:
        body_a, body_b = (
            plant.GetBodyByName(name, model) for name in (closure.body_a, closure.body_b)
        )
        if closure.type == "weld":
            plant.AddWeldConstraint(
                body_a, RigidTransform(closure.p_a), body_b, RigidTransform(closure.p_b)
            )
        else:
            plant.AddBallConstraint(body_a, np.array(closure.p_a), body_b, np.array(closure.p_b))
