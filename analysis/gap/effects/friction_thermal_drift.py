"""Friction that changes over minutes of running, from a cold machine to a warm one."""

import numpy as np

from ....models.drive import BACKWARD, FORWARD, VISCOUS, WIDTH
from ..machine import Machine, Plant
from .base import Effect, Form, Scales, Values, everywhere, parameter

WARM_UP = 200.0  # s


def forms(machine: Machine, scales: Scales) -> list[Form]:
    """Viscous and dry friction of the cold machine, decaying with the time it has run.

    Applies where the runs say how long the machine had been running (``start_s``).
    """
    if scales.duration < 10.0:
        return []
    viscous = parameter(
        "cold_viscous", machine.unit("viscous"), scales.effort / scales.rate, starts=(0.0,)
    )
    level = parameter("cold_level", machine.unit("effort"), scales.effort, lower=0.0)
    warm_up = parameter(
        "warm_up", "s", WARM_UP, lower=0.05 * scales.duration, upper=100.0 * scales.duration,
        starts=(WARM_UP, 0.3 * scales.duration, 3.0 * scales.duration),
    )  # fmt: skip

    def apply(plant: Plant, values: Values) -> None:
        cold = np.exp(-plant.time / values["warm_up"])
        n = len(machine.shafts)
        plant.drive.element[:n, VISCOUS] += cold * values.get("cold_viscous", 0.0)
        for side in (FORWARD, BACKWARD):
            plant.drive.element[:n, side] += cold * values.get("cold_level", 0.0)
        plant.drive.element[:n, WIDTH] = 0.01 * scales.rate

    return [
        Form(
            effect=EFFECT.id,
            name="exponential warm-up",
            parameters=(viscous, level, warm_up),
            apply=apply,
            where=everywhere("elements", machine.shafts),
            shapes=frozenset({"warm_up"}),
            removable=frozenset({"cold_viscous", "cold_level"}),
        )
    ]


EFFECT = Effect(
    id="friction.thermal_drift",
    summary="friction that changes over minutes of running",
    forms=forms,
    signature="unexplained friction that differs between early and late runs",
)
