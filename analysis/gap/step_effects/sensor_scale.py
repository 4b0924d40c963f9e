"""A wrong scale of the measured displacements, the same for all of them."""

from ..effects.base import Effect, Form, Values, parameter
from ..step_machine import StepMachine, StepPlant
from .base import Moves, everywhere


def forms(machine: StepMachine, moves: Moves) -> list[Form]:
    """One factor of all readings."""

    def apply(plant: StepPlant, values: Values) -> None:
        plant.reading *= 1.0 + values["scale_error"]

    return [
        Form(
            effect=EFFECT.id,
            name="all joints",
            parameters=(parameter("scale_error", "1", 0.05, lower=-0.5, upper=1.0),),
            apply=apply,
            where=everywhere(machine),
        )
    ]


EFFECT = Effect(
    id="sensor.scale",
    summary="wrong scale of the measured displacement",
    forms=forms,
    signature="all moves of all joints err by the same share",
)
