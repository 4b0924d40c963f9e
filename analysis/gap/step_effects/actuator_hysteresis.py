r"""A direction memory: stack and contact are wound up the other way when a move reverses the one before.

The move gains r steps (loses, if negative): all at once, over some steps, :math:`r(1 - e^{-n/m})`, or with
the load s lambda that opposes it, :math:`r + r_\lambda s\lambda`, as load and friction wind the contact up
together. Or it gains a distance of its own by direction, whatever is left of the step ((7) of ``slip_terms.py``): how
far the slider comes and falls back as stack and contact are wound up anew.
"""

from ..effects.base import Effect, Form, Values, parameter
from ..machine import Parameter
from ..step_machine import StepMachine, StepPlant
from .base import SIDES, UNITS, Moves, at_joints, removable


def forms(machine: StepMachine, moves: Moves) -> list[Form]:
    """Steps gained at a reversal, and over how many where moves differ in length."""
    if not moves.reversing:
        return []
    gains = [parameter(f"gain_{joint + 1}", "steps", 1.0) for joint in moves.reversing]
    with_load = [
        parameter(f"loadgain_{joint + 1}", "steps", 1.0)
        for joint in moves.reversing
        if joint in moves.loaded
    ]
    memory = parameter("memory", "steps", 5.0, lower=0.2, upper=200.0, starts=(5.0, 20.0))

    def apply(plant: StepPlant, values: Values) -> None:
        plant.memory = values.get("memory", 0.0)
        for joint in moves.reversing:
            plant.reversal[joint] += values.get(f"gain_{joint + 1}", 0.0)
            plant.reversal_load[joint] += values.get(f"loadgain_{joint + 1}", 0.0)

    choices: dict[str, list[Parameter]] = {"at once": [], "with the load": with_load}
    if moves.lengths_vary:
        choices["over some steps"] = [memory]
    found = [
        Form(
            effect=EFFECT.id,
            name=name,
            parameters=(*gains, *extra),
            apply=apply,
            where=at_joints,
            removable=removable([*gains, *with_load]),
            shapes=frozenset({"memory"}),
            own_start=True,
        )
        for name, extra in choices.items()
        if extra or name == "at once"
    ]
    return [*found, _distance(moves)]


def _distance(moves: Moves) -> Form:
    gains: dict[str, tuple[str, int, int]] = {}
    for joint in moves.reversing:
        for side in moves.sides[joint]:
            gains[f"reversal_{joint + 1}_{SIDES[side]}"] = ("reversal", joint, side)
            if joint in moves.loaded:
                gains[f"loaded_{joint + 1}_{SIDES[side]}"] = ("reversal_load", joint, side)
    parameters = [
        parameter(name, UNITS[joint], moves.step[joint]) for name, (_, joint, _) in gains.items()
    ]

    def apply(plant: StepPlant, values: Values) -> None:
        for name, (term, joint, side) in gains.items():
            getattr(plant.slip, term)[joint, side] += values.get(name, 0.0)

    return Form(
        effect=EFFECT.id,
        name="a distance by direction",
        parameters=tuple(parameters),
        apply=apply,
        where=at_joints,
        removable=removable(parameters),
        own_start=True,
    )


EFFECT = Effect(
    id="actuator.hysteresis",
    summary="steps gained or lost when the direction reverses",
    forms=forms,
    signature="moves that reverse the one before err by a fixed number of steps, or distance",
)
