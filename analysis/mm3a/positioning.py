"""How far off the tip ends after an open-loop move, against the distance, for each step model."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...models.mm3a import kinematics, open_loop, stepper
from ...models.mm3a.arm import Arm
from ...models.mm3a.step_size import StepModel
from ...models.mm3a.stepper import Conditions

START = (0.3, -1.2, 0.006)  # middle of the workspace: 4 mm are free in every direction
DISTANCES = (0.1e-3, 0.3e-3, 1e-3, 2e-3, 4e-3)  # [m]
SPEED = 5e-5  # slow enough for one step per joint and tick [m/s]


@dataclass(frozen=True, kw_only=True)
class ErrorGrowth:
    """Tip error [m] at the end of straight moves, per way of converting them to steps."""

    distances: tuple[float, ...]  # [m]
    errors: dict[str, NDArray[np.float64]]  # (distances, directions)

    def rms(self, name: str) -> NDArray[np.float64]:
        """Root mean square over the directions, per distance [m]."""
        return np.sqrt(np.mean(np.square(self.errors[name]), axis=1))


def error_growth(
    believed: dict[str, StepModel],
    *,
    true: StepModel | None = None,
    conditions: Conditions | None = None,
    directions: int = 12,
    distances: Sequence[float] = DISTANCES,
    seed: int = 0,
) -> ErrorGrowth:
    """Move in random directions by re-planning with each believed model, and differentially with the first.

    ``true`` and ``conditions`` are what really moves; tilt and tip force are known to the planner, factors of
    the day are not.
    """
    conditions = conditions or Conditions()
    known = Conditions(theta=conditions.theta, psi=conditions.psi, force=conditions.force)
    rng = np.random.default_rng(seed)
    ways = rng.normal(size=(directions, 3))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    first = next(iter(believed))
    names = [*believed, f"{first}, differential"]
    errors = {name: np.empty((len(distances), directions)) for name in names}
    for i, distance in enumerate(distances):
        for k, way in enumerate(ways):
            for name in names:
                model = believed.get(name, believed[first])
                commands = _commands(distance * way, model, known, name not in believed)
                end = stepper.run(commands, START, model=true, conditions=conditions).positions[-1]
                errors[name][i, k] = _miss(end, distance * way)
    return ErrorGrowth(distances=tuple(distances), errors=errors)


def _commands(
    move: NDArray[np.float64], model: StepModel, known: Conditions, differential: bool
) -> NDArray[np.int64]:
    if differential:
        return open_loop.interleave(
            open_loop.differential_steps(move, START, model=model, conditions=known)
        )
    tip = kinematics.tip(START, Arm())
    path = open_loop.straight_path(tip, np.add(tip, move), SPEED)
    return open_loop.follow(path, START, model=model, conditions=known)[0]


def _miss(end: NDArray[np.float64], move: NDArray[np.float64]) -> float:
    arm = Arm()
    reached = np.subtract(kinematics.tip(end, arm), kinematics.tip(START, arm))
    return float(np.linalg.norm(reached - move))
