"""A whole-sample or transport delay between command and torque."""

from ....models.drive import DELAY
from .base import Effect, Form, Scales, ShaftMachine, ShaftPlant, Values, everywhere, parameter


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """The same delay, whole or fractional samples, in every command path."""
    dt = scales.dt
    delay = parameter(
        "delay",
        "s",
        dt,
        lower=0.0,
        upper=10.0 * dt,
        starts=(0.0, 0.9 * dt, 1.5 * dt, 3.5 * dt),
    )
    return [
        Form(
            effect=EFFECT.id,
            name="transport delay",
            parameters=(delay,),
            apply=_apply,
            where=everywhere("joints", machine.joints),
            shifts=True,
        )
    ]


def _apply(plant: ShaftPlant, values: Values) -> None:
    plant.drive.shaft[:, DELAY] += values["delay"]


EFFECT = Effect(
    id="actuator.delay",
    summary="whole-sample or transport delay in the command path",
    forms=forms,
    signature="unexplained torque proportional to the change of the commanded torque",
)
