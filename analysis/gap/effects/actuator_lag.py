"""Finite bandwidth of the torque or current loop."""

from ....models.drive import LAG
from ..machine import Machine, Plant
from .base import Effect, Form, Scales, Values, everywhere, parameter


def forms(machine: Machine, scales: Scales) -> list[Form]:
    """The same first-order lag in every actuator."""
    dt = scales.dt
    lag = parameter(
        "time_constant", "s", dt, lower=0.0, upper=50.0 * dt, starts=(0.0, dt, 4.0 * dt)
    )
    return [
        Form(
            effect=EFFECT.id,
            name="first order",
            parameters=(lag,),
            apply=_apply,
            where=everywhere("joints", machine.shafts),
        )
    ]


def _apply(plant: Plant, values: Values) -> None:
    plant.drive.shaft[:, LAG] = values["time_constant"]


EFFECT = Effect(
    id="actuator.lag",
    summary="finite bandwidth of the torque or current loop",
    forms=forms,
    signature="unexplained torque proportional to the change of the command, smoothed",
)
