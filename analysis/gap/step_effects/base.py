"""What the moves of a log set excite, and how the places of step effects are named."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....models.mm3a import dynamics, step_size
from ..effects.base import parameter
from ..machine import Parameter
from ..step_machine import PRISMATIC, MoveRun, StepMachine

SIDES = ("negative", "positive")
ENDS = ("retracted", "extended")  # of the travel of joint 3
UNITS = ("rad", "rad", "m")  # of a step, by joint
LOADED = 0.02  # load factor from which a load shows
VARIED = 0.15  # spread of q3, over its travel, from which extension is varied


@dataclass(frozen=True, kw_only=True)
class Moves:
    """Excitation of the joints that move."""

    sides: dict[int, tuple[int, ...]]  # directions that joint moves in
    step: dict[int, float]  # typical step [rad or m]
    pull: dict[int, float]  # largest load of a joint over that of the level, retracted arm [-]
    loaded: tuple[int, ...]  # joints whose load is not always negligible
    extended: tuple[int, ...]  # rotary joints that move at different extensions
    folded: bool  # joint 3 moves at elbow angles with recoil
    reversing: tuple[int, ...]  # joints with moves that reverse the one before
    lengths_vary: bool  # moves after a reversal have different numbers of steps
    weighed: bool  # a mass on the tip would load a joint
    duration: float  # longest running time in a session [s]


def moves_of(machine: StepMachine, runs: Sequence[MoveRun]) -> Moves:
    """What these runs excite."""
    by_joint = {j: [run for run in runs if run.joint == j] for j in machine.moving}
    by_joint = {j: chosen for j, chosen in by_joint.items() if chosen}
    lengths = np.concatenate([run.steps[run.reverses] for run in runs])
    return Moves(
        sides={
            j: tuple(int(s) for s in np.unique(np.concatenate([run.side for run in chosen])))
            for j, chosen in by_joint.items()
        },
        step={j: float(np.max(machine.table[j, :, 0])) for j in by_joint},
        pull={j: _largest(chosen, "pull") for j, chosen in by_joint.items()},
        loaded=tuple(j for j, c in by_joint.items() if _largest(c, "load") > LOADED),
        extended=tuple(
            j
            for j, c in by_joint.items()
            if j != PRISMATIC and np.ptp(np.concatenate([r.extension[:, 0] for r in c])) > VARIED
        ),
        folded=any(np.max(np.abs(np.cos(r.elbow))) > LOADED for r in by_joint.get(PRISMATIC, [])),
        reversing=tuple(j for j, c in by_joint.items() if any(r.reverses.any() for r in c)),
        lengths_vary=lengths.size > 0 and float(lengths.max()) > 1.5 * float(lengths.min()),
        weighed=any(
            _largest(c, "load_per_kg") * machine.arm.mass_3 > LOADED for c in by_joint.values()
        ),
        duration=max(float(run.t[-1]) for run in runs),
    )


def _largest(runs: Sequence[MoveRun], name: str) -> float:
    return max(float(np.max(np.abs(getattr(run, name)))) for run in runs)


def joint_name(joint: int) -> str:
    """Name of a joint in a diagnosis."""
    return f"joint_{joint + 1}"


def at_joints(names: Sequence[str]) -> dict[str, Any]:
    """Places from parameter names that hold the number of a joint: ``load_3_positive``."""
    joints = {f"joint_{part}" for name in names for part in name.split("_") if part.isdigit()}
    return {"joints": sorted(joints)}


def at_joints_of(*prefixes: str) -> Callable[[Sequence[str]], dict[str, Any]]:
    """Places from those parameter names only that begin with one of ``prefixes``."""
    return lambda names: at_joints([n for n in names if n.startswith(prefixes)])


def grips(moves: Moves) -> list[Parameter]:
    """By joint, the load from which its contact slips, over that of the level, retracted arm."""
    found = []
    for joint, pull in moves.pull.items():
        least = max(pull, 0.1)
        found.append(
            parameter(f"grip_{joint + 1}", "1", 5.0 * least, lower=1.1 * least, upper=100.0 * least,
                starts=(5.0 * least,))
        )  # fmt: skip
    return found


def fallbacks(machine: StepMachine, moves: Moves) -> list[Parameter]:
    r"""By joint, what its slider falls back without load, level and retracted [rad or m].

    It is inversely proportional to the inertia, so a rotary joint whose stated steps grow with its extension
    states it: :math:`B = (\gamma_{ext} - \gamma_{ret})/(1 - 1/i_{ext})`. Of others it is half a step to two.
    """
    found = []
    for joint, step in moves.step.items():
        stated = _stated_fallback(machine, joint)
        middle, low, high = (0.7 * step, 0.2 * step, 2.0 * step)
        if low < stated < high:
            middle, low, high = stated, 0.85 * stated, 1.15 * stated
        found.append(
            parameter(f"fallback_{joint + 1}", UNITS[joint], step, lower=low, upper=high, starts=(middle,))
        )  # fmt: skip
    return found


def _stated_fallback(machine: StepMachine, joint: int) -> float:
    retracted, extended = (
        dynamics.mass_diagonal((*step_size.LEVEL, q3), machine.arm)[joint]
        for q3 in (machine.arm.lower_3, machine.arm.upper_3)
    )
    if joint == PRISMATIC or not extended > retracted:
        return 0.0
    growth = np.mean(machine.table[joint, :, 1] - machine.table[joint, :, 0])
    return float(growth / (1.0 - retracted / extended))


def everywhere(machine: StepMachine) -> Callable[[Sequence[str]], dict[str, Any]]:
    """All joints that move."""
    return lambda names: {"joints": list(machine.places)}


def own_of(machine: StepMachine, prefix: str) -> frozenset[str]:
    """Own parameters of one sort."""
    return frozenset(p.name for p in machine.own if p.name.startswith(prefix))


def removable(parameters: Sequence[Parameter]) -> frozenset[str]:
    """Their names."""
    return frozenset(p.name for p in parameters)
