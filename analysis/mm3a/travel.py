"""Fig. 4.11 again: how far joint 3 has come against the steps commanded, read from a microscope image."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...models.mm3a import stepper
from ...models.mm3a.arm import Arm
from ...models.mm3a.stepper import Conditions
from .experiments import Environment

PIXEL = 54.79e-6  # of the image, as printed [m]
LEVEL = -0.5 * np.pi
EVERY = 1000  # steps between two readings


@dataclass(frozen=True, kw_only=True)
class Travel:
    """Readings of one pass over the travel of joint 3."""

    direction: int  # -1 inward, 1 outward
    steps: NDArray[np.int64]  # (n,) commanded so far
    read: NDArray[np.float64]  # (n,) distance, in whole pixels [m]

    @property
    def departure(self) -> float:
        """Rms distance of the readings from the straight line through them [m]."""
        line = np.polynomial.Polynomial.fit(self.steps, self.read, 1)
        return float(np.sqrt(np.mean((self.read - line(self.steps)) ** 2)))


def passes(readings: int = 3, seed: int = 0) -> list[Travel]:
    """Outward and inward passes at q2 = -pi/2, theta = psi = 0, each with the scatter of a run."""
    arm, scatter = Arm(), Environment().run
    rng = np.random.default_rng(seed)
    return [
        _pass(direction, 1.0 + scatter * rng.standard_normal(), arm)
        for direction in (1, -1)
        for _ in range(readings)
    ]


def _pass(direction: int, factor: float, arm: Arm) -> Travel:
    start = (0.0, LEVEL, arm.lower_3 if direction > 0 else arm.upper_3)
    conditions = Conditions(scale=((factor, factor),) * 3)
    target = arm.upper_3 if direction > 0 else arm.lower_3
    total = stepper.steps_between(2, start, target, arm=arm, conditions=conditions) - 1
    commands = np.zeros((total, 3), dtype=np.int64)
    commands[:, 2] = direction
    moved = np.abs(
        stepper.run(commands, start, arm=arm, conditions=conditions).positions[:, 2] - start[2]
    )
    steps = np.arange(0, total + 1, EVERY)
    return Travel(direction=direction, steps=steps, read=PIXEL * np.round(moved[steps] / PIXEL))
