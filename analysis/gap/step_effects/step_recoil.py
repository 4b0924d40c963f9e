r"""Steps of joint 3 that shrink with the elbow angle: the frame recoils, :math:`1 - b|\cos q_2|` (4.3).

Damani's power of the cosine is 1; a compliant frame would have 2, as the recoil that bends it is a component
of the force and only a component of the bending is along the joint. One form leaves the power free. Another is that
frame, in series with the stack ((5) of ``slip_terms.py``): it takes stroke, the same whatever the load leaves of the step.
"""

from ..effects.base import Effect, Form, Values, parameter
from ..step_machine import PRISMATIC, StepMachine, StepPlant
from .base import SIDES, UNITS, Moves, own_of, removable


def forms(machine: StepMachine, moves: Moves) -> list[Form]:
    """One loss for both directions, one for each, and one with a free power."""
    if not moves.folded:
        return []
    each = [
        parameter(f"recoil_{SIDES[side]}", "1", 0.1, lower=-1.0, upper=1.0)
        for side in moves.sides[PRISMATIC]
    ]
    common = parameter("recoil", "1", 0.1, lower=-1.0, upper=1.0)
    power = parameter("power", "1", 1.0, lower=1.0, upper=6.0, starts=(2.0,))

    def apply(plant: StepPlant, values: Values) -> None:
        plant.table[PRISMATIC, :, 1] += values.get("recoil", 0.0)
        for side, name in enumerate(SIDES):
            plant.table[PRISMATIC, side, 1] += values.get(f"recoil_{name}", 0.0)
        plant.recoil_power = values.get("power", 1.0)

    choices = {
        "both directions": [common],
        "by direction": each,
        "any power of the cosine": [common, power],
    }
    found = [
        Form(
            effect=EFFECT.id,
            name=name,
            parameters=tuple(parameters),
            apply=apply,
            where=lambda names: {"joints": ["joint_3"]},
            removable=removable(parameters) if parameters == each else frozenset(),
            shapes=frozenset({"power"}),
            replaces=own_of(machine, "recoil_"),
            own_start=True,
        )
        for name, parameters in choices.items()
    ]
    return [*found, _frame(machine, moves)]


def _frame(machine: StepMachine, moves: Moves) -> Form:
    def apply(plant: StepPlant, values: Values) -> None:
        plant.slip.frame += values["stroke"]
        plant.slip.compliance = values["compliance"]

    step = moves.step[PRISMATIC]
    return Form(
        effect=EFFECT.id,
        name="compliant frame",
        parameters=(
            parameter("stroke", UNITS[PRISMATIC], 0.1 * step, lower=-step, upper=3.0 * step),
            parameter("compliance", "1", 0.2, lower=0.0, upper=3.0, starts=(0.2,)),
        ),
        apply=apply,
        where=lambda names: {"joints": ["joint_3"]},
        shapes=frozenset({"compliance"}),
        replaces=own_of(machine, "recoil_"),
        own_start=True,
    )


EFFECT = Effect(
    id="step.recoil",
    summary="steps lost to a frame that recoils",
    forms=forms,
    signature="moves of joint 3 err with the elbow angle, whatever the load",
)
