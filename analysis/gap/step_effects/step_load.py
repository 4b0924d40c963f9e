r"""Steps that depend on the static load otherwise than the stated law says.

1. by direction          :math:`\Delta\gamma = -c\lambda` (joint 3), :math:`d\lambda` (joints 1, 2)
2. by extension as well  d between the ends of the travel of joint 3, (6.9) of Damani 2013
3. curved                one of these, less :math:`k\lambda^2`
4. all alike             every stated load term by one factor
"""

from ..effects.base import Effect, Form, Values, parameter
from ..machine import Parameter
from ..step_machine import PRISMATIC, StepMachine, StepPlant
from .base import ENDS, SIDES, UNITS, Moves, at_joints, everywhere, own_of, removable


def forms(machine: StepMachine, moves: Moves) -> list[Form]:
    """Forms (1) to (4), as far as the moves are loaded."""
    if not moves.loaded:
        return []
    plain = _linear(moves, ends=False)
    found = [
        _form(machine, "by direction", plain),
        _form(machine, "curved", plain + _curves(moves)),
    ]
    if moves.extended:
        ends = _linear(moves, ends=True)
        found.insert(1, _form(machine, "by direction and extension", ends))
        found.append(_form(machine, "curved, by extension", ends + _curves(moves)))
    if own_of(machine, "load_"):
        found.append(_alike(machine))
    return found


def _linear(moves: Moves, *, ends: bool) -> list[Parameter]:
    found = []
    for joint in moves.loaded:
        for side in moves.sides[joint]:
            name = f"load_{joint + 1}_{SIDES[side]}"
            both = ends and joint in moves.extended
            for suffix in [f"_{end}" for end in ENDS] if both else [""]:
                found.append(parameter(name + suffix, UNITS[joint], 0.1 * moves.step[joint]))
    return found


def _curves(moves: Moves) -> list[Parameter]:
    return [
        parameter(f"curve_{joint + 1}_{SIDES[side]}", UNITS[joint], 0.1 * moves.step[joint])
        for joint in moves.loaded
        for side in moves.sides[joint]
    ]


def _form(machine: StepMachine, name: str, parameters: list[Parameter]) -> Form:
    def apply(plant: StepPlant, values: Values) -> None:
        for key, value in values.items():
            term, joint_text, side_text, *end = key.split("_")
            joint, side = int(joint_text) - 1, SIDES.index(side_text)
            if term == "curve":
                plant.curve[joint, side] += value
            elif joint == PRISMATIC:
                plant.table[joint, side, 2] += value
            else:
                columns = [2 + ENDS.index(end[0])] if end else [2, 3]
                plant.table[joint, side, columns] += value

    return Form(
        effect=EFFECT.id,
        name=name,
        parameters=tuple(parameters),
        apply=apply,
        where=at_joints,
        removable=removable(parameters),
        replaces=own_of(machine, "load_"),
    )


def _alike(machine: StepMachine) -> Form:
    def apply(plant: StepPlant, values: Values) -> None:
        factor = 1.0 + values["load_share"]
        plant.table[:PRISMATIC, :, 2:] *= factor
        plant.table[PRISMATIC, :, 2] *= factor
        plant.curve *= factor

    return Form(
        effect=EFFECT.id,
        name="all alike",
        parameters=(parameter("load_share", "1", 0.2, lower=-1.0),),
        apply=apply,
        where=everywhere(machine),
        replaces=own_of(machine, "load_"),
        own_start=True,
    )


EFFECT = Effect(
    id="step.load",
    summary="steps that depend on gravity or another static load",
    forms=forms,
    signature="moves err one way against the load and the other way with it",
)
