"""Steps that differ by direction at equal load and posture."""

from ..effects.base import Effect, Form, Values, parameter
from ..step_machine import StepMachine, StepPlant
from .base import Moves, at_joints, removable


def forms(machine: StepMachine, moves: Moves) -> list[Form]:
    """Half the relative difference between the directions, for every joint that moves both ways."""
    both = [joint for joint, sides in moves.sides.items() if len(sides) == 2]
    if not both:
        return []
    parameters = tuple(parameter(f"asymmetry_{joint + 1}", "1", 0.05) for joint in both)

    def apply(plant: StepPlant, values: Values) -> None:
        for joint in both:
            share = values.get(f"asymmetry_{joint + 1}", 0.0)
            plant.change[joint] += (-share, share)

    return [
        Form(
            effect=EFFECT.id,
            name="asymmetry",
            parameters=parameters,
            apply=apply,
            where=at_joints,
            removable=removable(parameters),
        )
    ]


EFFECT = Effect(
    id="step.direction",
    summary="steps that differ by direction",
    forms=forms,
    signature="moves of the two directions err by the same share, with opposite signs",
)
