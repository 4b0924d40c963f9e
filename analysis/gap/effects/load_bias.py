"""A constant load: a hanging weight, a cable, an unbalanced counterweight."""

from ....models.drive import BIAS
from .base import Effect, Form, Scales, ShaftMachine, ShaftPlant, Values, at, parameter


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """One constant effort for each shaft."""
    parameters = tuple(
        parameter(f"bias_{s}", machine.unit("effort"), scales.effort, starts=(0.0,))
        for s in machine.joints
    )

    def apply(plant: ShaftPlant, values: Values) -> None:
        for j, s in enumerate(machine.joints):
            plant.drive.shaft[j, BIAS] += values.get(f"bias_{s}", 0.0)

    return [
        Form(
            effect=EFFECT.id,
            name="constant",
            parameters=parameters,
            apply=apply,
            where=at("joints", "bias_"),
            removable=frozenset(p.name for p in parameters),
        )
    ]


EFFECT = Effect(
    id="load.bias",
    summary="constant or gravity-like load, cable force, counterweight",
    forms=forms,
    signature="unexplained torque that stays the same whatever the motion",
)
