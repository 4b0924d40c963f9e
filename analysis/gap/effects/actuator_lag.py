"""Finite bandwidth of the torque or current loop."""

from collections.abc import Callable

from ....models.drive import LAG, STAGES
from .base import (
    Effect,
    Form,
    Scales,
    ShaftMachine,
    ShaftPlant,
    Values,
    everywhere,
    parameter,
)


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """The same lag in every actuator, of one stage or of two equal ones."""
    dt = scales.dt
    lag = parameter(
        "time_constant", "s", dt, lower=0.0, upper=50.0 * dt, starts=(0.0, dt, 4.0 * dt)
    )
    return [
        Form(
            effect=EFFECT.id,
            name=name,
            parameters=(lag,),
            apply=_lag(stages),
            where=everywhere("joints", machine.joints),
            shifts=True,
        )
        for stages, name in enumerate(("first order", "second order"), 1)
    ]


def _lag(stages: int) -> Callable[[ShaftPlant, Values], None]:
    def apply(plant: ShaftPlant, values: Values) -> None:
        plant.drive.shaft[:, LAG] = values["time_constant"]
        plant.drive.shaft[:, STAGES] = stages

    return apply


EFFECT = Effect(
    id="actuator.lag",
    summary="finite bandwidth of the torque or current loop",
    forms=forms,
    signature="unexplained torque proportional to the change of the command, smoothed",
)
