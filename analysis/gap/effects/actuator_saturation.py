"""A torque, current or voltage limit that clips the command."""

from ....models.drive import LIMIT
from .base import Effect, Form, Scales, ShaftMachine, ShaftPlant, Values, everywhere, parameter


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """One limit for all actuators; it has no gradient until it bites, so it starts inside the data."""
    peak = scales.effort_peak
    limit = parameter(
        "limit",
        machine.unit("effort"),
        peak,
        lower=0.05 * peak,
        upper=peak,
        starts=(0.999 * peak, 0.9 * peak, 0.75 * peak, 0.55 * peak, 0.35 * peak),
    )
    return [
        Form(
            effect=EFFECT.id,
            name="clipped command",
            parameters=(limit,),
            apply=_apply,
            where=everywhere("joints", machine.joints),
        )
    ]


def _apply(plant: ShaftPlant, values: Values) -> None:
    plant.drive.shaft[:, LIMIT] = values["limit"]


EFFECT = Effect(
    id="actuator.saturation",
    summary="torque, current or voltage limit",
    forms=forms,
    signature="unexplained torque only where the command is large",
)
