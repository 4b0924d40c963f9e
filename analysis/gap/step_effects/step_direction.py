r"""Steps that differ by direction at equal load and posture.

1. asymmetry  every step by a share, half the difference each way
2. flyback    the stack flies back in :math:`t_f(1 \mp \beta/2)`: the slider, which falls back with the square of that
   time, loses more in one direction ((1), (4) of ``slip_terms.py``), most of all against a
   load. With :math:`\delta = \beta B` that is :math:`c_\mp = \pm\delta + \delta^2/4B`
"""

from ..effects.base import Effect, Form, Values, parameter
from ..step_machine import StepMachine, StepPlant
from .base import UNITS, Moves, at_joints, at_joints_of, fallbacks, grips, removable


def forms(machine: StepMachine, moves: Moves) -> list[Form]:
    """Forms (1) and (2), for every joint that moves both ways."""
    both = [joint for joint, sides in moves.sides.items() if len(sides) == 2]
    if not both:
        return []
    parameters = tuple(parameter(f"asymmetry_{joint + 1}", "1", 0.05) for joint in both)

    def apply(plant: StepPlant, values: Values) -> None:
        for joint in both:
            share = values.get(f"asymmetry_{joint + 1}", 0.0)
            plant.change[joint] += (-share, share)

    plain = Form(
        effect=EFFECT.id,
        name="asymmetry",
        parameters=parameters,
        apply=apply,
        where=at_joints,
        removable=removable(parameters),
    )
    return [plain, _flyback(machine, moves, both)]


def _flyback(machine: StepMachine, moves: Moves, both: list[int]) -> Form:
    differences = [
        parameter(f"flyback_{joint + 1}", UNITS[joint], 0.05 * moves.step[joint]) for joint in both
    ]
    names = {str(joint + 1) for joint in both}
    shapes = [
        p for p in (*fallbacks(machine, moves), *grips(moves)) if p.name.split("_")[1] in names
    ]

    def apply(plant: StepPlant, values: Values) -> None:
        for joint in both:
            less = values.get(f"flyback_{joint + 1}", 0.0)
            even = 0.25 * less**2 / values[f"fallback_{joint + 1}"]
            plant.slip.flyback[joint] += [even + less, even - less]
            plant.slip.flyback_grip[joint] = values[f"grip_{joint + 1}"]

    return Form(
        effect=EFFECT.id,
        name="flyback",
        parameters=(*differences, *shapes),
        apply=apply,
        where=at_joints_of("flyback_"),
        removable=removable(differences),
        shapes=frozenset(p.name for p in shapes),
        own_start=True,
    )


EFFECT = Effect(
    id="step.direction",
    summary="steps that differ by direction",
    forms=forms,
    signature="moves of the two directions err by the same share or amount, with opposite signs",
)
