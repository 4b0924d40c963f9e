"""What control and simulation need to know of a parallel machine, and the five-bar as one."""

from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from . import five_bar
from .energy import Equations, Floats
from .five_bar import FiveBar


class ParallelMachine(Protocol):
    """A machine in its n actuated coordinates q with n task coordinates x."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the actuated joints."""

    @property
    def task(self) -> tuple[str, ...]:
        """Names of the task coordinates."""

    def equations(self, q: ArrayLike, v: ArrayLike) -> Equations:
        """Equations of motion of the machine without its actuators at q and rates v (n,)."""

    def forward(self, q: ArrayLike) -> Floats:
        """Task coordinates (..., n) at q (..., n); NaN where the loops do not close."""

    def inverse(self, x: ArrayLike) -> Floats:
        """Joint coordinates (..., n) at x (..., n); NaN out of reach."""

    def task_motion(self, q: ArrayLike, v: ArrayLike) -> tuple[Floats, Floats]:
        """Jacobian J (..., n, n) of x by q, and Jdot v (..., n)."""


@dataclass(frozen=True, kw_only=True)
class FiveBarMachine:
    """Five-bar in one working mode and one assembly mode; joint coordinates are crank angles [rad]."""

    geometry: FiveBar = field(default_factory=FiveBar)
    modes: tuple[int, int] = (1, -1)  # sides of both elbows, see ``five_bar.inverse``
    assembly: int = 1  # side of the rods' joint, see ``five_bar.forward``
    joints: tuple[str, ...] = ("crank1", "crank4")
    task: tuple[str, ...] = ("x", "y")

    def equations(self, q: ArrayLike, v: ArrayLike) -> Equations:
        """Equations of motion at one posture."""
        return five_bar.equations(q, v, self.geometry, self.assembly)

    def forward(self, q: ArrayLike) -> Floats:
        """Tool positions [m]."""
        return five_bar.forward(q, self.geometry, self.assembly).tool

    def inverse(self, x: ArrayLike) -> Floats:
        """Crank angles [rad]."""
        return five_bar.inverse(x, self.geometry, self.modes)

    def task_motion(self, q: ArrayLike, v: ArrayLike) -> tuple[Floats, Floats]:
        """Jacobian and drift of the tool."""
        if np.ndim(q) == 1:
            return five_bar.tool_motion(q, v, self.geometry, self.assembly)
        motion = five_bar.motion(q, v, self.geometry, self.assembly)
        tool = five_bar.BODIES.index("tool")
        return motion.jacobian[..., tool, :2, :], motion.drift[..., tool, :2]


def joint_motion(
    machine: ParallelMachine, x: ArrayLike, v: ArrayLike, a: ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """Joint positions, rates and accelerations (..., n) of a motion of the task coordinates (..., n)."""
    q = machine.inverse(x)
    jacobian, _ = machine.task_motion(q, np.zeros_like(q))
    rate = np.linalg.solve(jacobian, np.asarray(v)[..., None])[..., 0]
    _, drift = machine.task_motion(q, rate)
    return q, rate, np.linalg.solve(jacobian, (np.asarray(a) - drift)[..., None])[..., 0]
