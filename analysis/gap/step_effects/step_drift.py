r"""Steps that change from day to day or while the actuators warm up (sections 4.2, 5.2, reference 51).

1. day      one factor by session and joint, or by direction as well
2. warming  :math:`1 + h_j(1 - e^{-t/\tau})` with the running time t of the session
3. stroke   as (1) and (2), but by an amount: what changes is the stroke of the stack, not what the slider falls
   back ((6) of ``slip_terms.py``)
"""

from collections.abc import Callable, Mapping, Sequence

from ..effects.base import Effect, Form, Values, parameter
from ..machine import Parameter
from ..step_machine import StepMachine, StepPlant
from .base import SIDES, UNITS, Moves, at_joints, own_of, removable

Key = tuple[int, int, tuple[int, ...]]  # session, joint, sides


def forms(machine: StepMachine, moves: Moves) -> list[Form]:
    """Forms (1) to (3)."""
    days = range(len(machine.sessions))
    joints = {(d, j): (d, j, sides) for d in days for j, sides in moves.sides.items()}
    found = [
        _day(machine, "day to day", {f"day{d + 1}_{_n(j)}": key for (d, j), key in joints.items()}),
        _warming(moves),
        _stroke_by_day(machine, moves),
        _warming(moves, stroke=True),
    ]
    if len(machine.sessions) > 1:  # in one session it is a difference between directions
        each: dict[str, Key] = {
            f"day{d + 1}_{_n(j)}_{SIDES[side]}": (d, j, (side,))
            for d, j, sides in joints.values()
            for side in sides
        }
        found.append(_day(machine, "day to day, by direction", each))
    return found


def _n(joint: int) -> str:
    return str(joint + 1)


def _day(machine: StepMachine, name: str, places: dict[str, Key]) -> Form:
    parameters = [parameter(key, "1", 0.05, lower=-0.5, upper=1.0) for key in places]

    def apply(plant: StepPlant, values: Values) -> None:
        for key, (session, joint, sides) in places.items():
            plant.day[session, joint, list(sides)] += values.get(key, 0.0)

    sessions = {key: place[0] for key, place in places.items()}
    return _by_session(machine, name, sessions, parameters, apply)


def _stroke_by_day(machine: StepMachine, moves: Moves) -> Form:
    places = {
        f"stroke{d + 1}_{_n(j)}": (d, j) for d in range(len(machine.sessions)) for j in moves.sides
    }
    parameters = [
        parameter(name, UNITS[j], 0.05 * moves.step[j], lower=-0.5 * moves.step[j], upper=moves.step[j])
        for name, (_, j) in places.items()
    ]  # fmt: skip

    def apply(plant: StepPlant, values: Values) -> None:
        for name, key in places.items():
            plant.slip.day[key] = plant.slip.day.get(key, 0.0) + values.get(name, 0.0)

    sessions = {key: place[0] for key, place in places.items()}
    return _by_session(machine, "stroke by day", sessions, parameters, apply)


def _by_session(
    machine: StepMachine,
    name: str,
    sessions: Mapping[str, int],
    parameters: Sequence[Parameter],
    apply: Callable[[StepPlant, Values], None],
) -> Form:
    """A form whose parameters act in one session each: ``sessions`` by parameter."""
    return Form(
        effect=EFFECT.id,
        name=name,
        parameters=tuple(parameters),
        apply=apply,
        where=lambda names: {
            **at_joints([n.split("_", 1)[1] for n in names]),
            "sessions": sorted({machine.sessions[sessions[n]] for n in names}),
        },
        removable=removable(parameters),
        replaces=own_of(machine, "basic_"),
        own_start=True,
    )


def _warming(moves: Moves, *, stroke: bool = False) -> Form:
    growth: list[Parameter] = [
        parameter(
            f"warming_{_n(j)}",
            UNITS[j] if stroke else "1",
            0.05 * size,
            lower=-0.9 * size,
            upper=5.0 * size,
        )
        for j in moves.sides
        for size in [moves.step[j] if stroke else 1.0]
    ]
    span = max(moves.duration, 1.0)
    warm_up = parameter(
        "warm_up", "s", 0.3 * span, lower=0.01 * span, upper=10.0 * span,
        starts=(0.3 * span, 0.05 * span, 2.0 * span),
    )  # fmt: skip

    def apply(plant: StepPlant, values: Values) -> None:
        plant.warm_up = values["warm_up"]
        for joint in moves.sides:
            changed = plant.slip.warming if stroke else plant.warming
            changed[joint] += values.get(f"warming_{_n(joint)}", 0.0)

    return Form(
        effect=EFFECT.id,
        name="warming stroke" if stroke else "warming",
        parameters=(*growth, warm_up),
        apply=apply,
        where=at_joints,
        removable=removable(growth),
        shapes=frozenset({"warm_up"}),
        own_start=True,
    )


EFFECT = Effect(
    id="step.drift",
    summary="steps that change from day to day or with running time",
    forms=forms,
    signature="all moves of a session, or of its beginning, err by the same share",
)
