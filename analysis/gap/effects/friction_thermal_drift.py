"""Friction that changes over minutes of running, from a cold machine to a warm one."""

import numpy as np

from ....models.drive import (
    BACKWARD,
    FADE,
    FORWARD,
    STRIBECK_EXPONENT,
    STRIBECK_SPEED,
    VISCOUS,
    WIDTH,
)
from .base import (
    RARE,
    Effect,
    Form,
    Scales,
    ShaftMachine,
    ShaftPlant,
    Values,
    everywhere,
    parameter,
)
from .dry_friction import keep_stable, width_parameter

WARM_UP = 200.0  # s


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """Viscous and dry friction of the cold machine, dying away with the time it has run.

    The lubricant is the same everywhere, so all viscous friction thickens by one share. Applies
    where the runs say how long the machine had been running (``start_s``).
    """
    if scales.duration < 10.0:
        return []
    excess = parameter("cold_viscous_share", "-", 0.5)
    level = parameter("cold_level", machine.unit("effort"), scales.effort, lower=0.0)
    warm_up = parameter(
        "warm_up", "s", WARM_UP, lower=0.05 * scales.duration, upper=10.0 * scales.duration,
        starts=(WARM_UP, 0.3 * scales.duration, 3.0 * scales.duration),
    )  # fmt: skip

    def apply(plant: ShaftPlant, values: Values) -> None:
        left = np.exp(-plant.time / values["warm_up"])
        n = len(machine.joints)
        cold = np.zeros_like(plant.drive.element)
        cold[:, VISCOUS] = left * values.get("cold_viscous_share", 0.0)
        cold[:, VISCOUS] *= plant.drive.element[:, VISCOUS]
        cold[:n, [FORWARD, BACKWARD]] = left * values.get("cold_level", 0.0)
        for column in (STRIBECK_SPEED, STRIBECK_EXPONENT):
            cold[:, column] = plant.drive.element[:, column]
        cold[:, WIDTH] = values["width"]
        cold[:, FADE] = 1.0 / values["warm_up"]
        plant.drive = plant.drive._replace(
            elements=np.vstack([plant.drive.elements, plant.drive.elements]),
            element=np.vstack([plant.drive.element, cold]),
        )
        keep_stable(plant, scales)

    return [
        Form(
            effect=EFFECT.id,
            name="exponential warm-up",
            parameters=(excess, level, warm_up, width_parameter(machine, scales)),
            apply=apply,
            where=everywhere("elements", machine.joints),
            shapes=frozenset({"warm_up", "width"}),
            removable=frozenset({"cold_viscous_share", "cold_level"}),
            price=RARE,  # where nothing fades it is plain friction with fewer levels
        )
    ]


EFFECT = Effect(
    id="friction.thermal_drift",
    summary="friction that changes over minutes of running",
    forms=forms,
    signature="unexplained friction that differs between early and late runs",
)
