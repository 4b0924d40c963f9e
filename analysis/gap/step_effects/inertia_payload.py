"""A mass on the tip that the stated arm does not have: weight through J^T, and inertia.

How a stick-slip step depends on inertia has no known law (section 5.4 of Damani 2013): it is a share by joint.
"""

from ..effects.base import Effect, Form, Values, parameter
from ..machine import Parameter
from ..step_machine import StepMachine, StepPlant
from .base import Moves, everywhere, removable


def forms(machine: StepMachine, moves: Moves) -> list[Form]:
    """The weight alone, and with a share of every step for the inertia."""
    if not moves.weighed:
        return []
    mass = parameter(
        "mass", "kg", machine.arm.mass_3, lower=-0.9 * machine.arm.mass_3, upper=0.1
    )  # fmt: skip
    shares = [parameter(f"inertia_{joint + 1}", "1", 0.05, lower=-0.9) for joint in moves.sides]

    def apply(plant: StepPlant, values: Values) -> None:
        plant.payload += values["mass"]
        for joint in moves.sides:
            plant.change[joint] += values.get(f"inertia_{joint + 1}", 0.0)

    choices: dict[str, list[Parameter]] = {"weight": [], "weight and inertia": shares}
    return [
        Form(
            effect=EFFECT.id,
            name=name,
            parameters=(mass, *extra),
            apply=apply,
            where=everywhere(machine),
            removable=removable(extra),
        )
        for name, extra in choices.items()
    ]


EFFECT = Effect(
    id="inertia.payload",
    summary="mass on the tip that the model does not have",
    forms=forms,
    signature="moves err with the load of every joint, as one mass on the tip would have them",
)
