"""What control and simulation need to know of a parallel machine, and each machine as one."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike

from . import energy, five_bar, mast, prs, three_prs, two_prr
from .energy import Equations, Floats
from .five_bar import FiveBar
from .three_prs import Flexures
from .two_prr import TwoPRR


class Part(Protocol):
    """Bodies of a machine that move together with it."""

    def equations(self, q: ArrayLike, v: ArrayLike) -> Equations:
        """Equations of motion without the actuators at q and rates v (..., n)."""


class ParallelMachine(Part, Protocol):
    """A machine in its n actuated coordinates q with n task coordinates x."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the actuated joints."""

    @property
    def task(self) -> tuple[str, ...]:
        """Names of the task coordinates."""

    def parts(self) -> Mapping[str, Part]:
        """``machine``, all of it, and by name what one kilogram more of a body or load would be."""

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
        """Equations of motion; compiled for one posture."""
        g = self.geometry
        if np.ndim(q) == 1:
            return five_bar.equations(q, v, g, self.assembly)
        motion = five_bar.motion(q, v, g, self.assembly)
        return energy.equations(motion, g.body_masses, g.body_inertias, g.weight)

    def parts(self) -> Mapping[str, Part]:
        """The machine, and one kilogram at the tool."""
        alone = replace(
            self.geometry,
            masses=(0.0, 0.0, 0.0, 0.0, 1.0),
            inertias=(0.0, 0.0, 0.0, 0.0),
            rotors=(0.0, 0.0),
        )
        return {"machine": self, "tool": replace(self, geometry=alone)}

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


@dataclass(frozen=True, kw_only=True)
class TwoPRRMachine:
    """2-PRR with parallelogram, platform below its sliders; joint coordinates are slider positions [m]."""

    geometry: TwoPRR = field(default_factory=TwoPRR)
    joints: tuple[str, ...] = ("slider1", "slider2")
    task: tuple[str, ...] = ("x", "y")

    def equations(self, q: ArrayLike, v: ArrayLike) -> Equations:
        """Equations of motion."""
        g = self.geometry
        return energy.equations(
            two_prr.motion(q, v, g), np.array(g.masses), g.body_inertias, g.weight
        )

    def parts(self) -> Mapping[str, Part]:
        """The machine, and one kilogram on the platform."""
        alone = replace(
            self.geometry, masses=(0.0, 0.0, 0.0, 0.0, 0.0, 1.0), bar_inertias=(0.0, 0.0, 0.0)
        )
        return {"machine": self, "platform": replace(self, geometry=alone)}

    def forward(self, q: ArrayLike) -> Floats:
        """Platform positions [m]."""
        return two_prr.forward(q, self.geometry)

    def inverse(self, x: ArrayLike) -> Floats:
        """Slider positions [m]."""
        return two_prr.inverse(x, self.geometry)

    def task_motion(self, q: ArrayLike, v: ArrayLike) -> tuple[Floats, Floats]:
        """Jacobian and drift of the platform, which does not turn."""
        motion = two_prr.motion(q, v, self.geometry)
        platform = two_prr.BODIES.index("platform")
        return motion.jacobian[..., platform, :2, :], motion.drift[..., platform, :2]


@dataclass(frozen=True, kw_only=True)
class TableMachine:
    """A table on three P-R-S legs; joint coordinates are slider positions [m].

    With ``flexures`` for its passive joints, level and unloaded at slider positions zero.
    """

    table: prs.Table = mast.MAST
    flexures: Flexures | None = None
    joints: tuple[str, ...] = ("slider1", "slider2", "slider3")
    task: tuple[str, ...] = ("z", "psi", "theta")

    def equations(self, q: ArrayLike, v: ArrayLike) -> Equations:
        """Equations of motion; what the flexures pull stands with gravity."""
        x = prs.forward(q, self.table)
        rigid = prs.dynamics(q, v, self.table, x)
        if self.flexures is None:
            return rigid
        pull = three_prs.elastic_force(x, q, self.table, self.flexures)
        return rigid._replace(gravity=rigid.gravity + pull)

    def parts(self) -> Mapping[str, Part]:
        """The table, and one kilogram at the platform's origin."""
        alone = replace(
            self.table,
            bar_mass=0.0,
            bar_inertia=0.0,
            platform_mass=1.0,
            platform_inertia=(0.0,) * 6,
            carriage_mass=0.0,
            platform_centre=(0.0, 0.0, 0.0),
        )
        return {"machine": self, "platform": replace(self, table=alone, flexures=None)}

    def forward(self, q: ArrayLike) -> Floats:
        """Height [m] and angles psi, theta [rad] of the platform."""
        return prs.forward(q, self.table)

    def inverse(self, x: ArrayLike) -> Floats:
        """Slider positions [m]."""
        return prs.inverse(x, self.table)

    def task_motion(self, q: ArrayLike, v: ArrayLike) -> tuple[Floats, Floats]:
        """Jacobian of the tasks, and its drift by central differences along the motion (h = 1e-6 s)."""
        h = 1e-6
        q, v = np.asarray(q, dtype=float), np.asarray(v, dtype=float)

        x = prs.forward(q, self.table)
        now = prs.task_jacobian(x, q, self.table)
        if not np.any(v):
            return now, np.zeros_like(v)

        def jacobian(at: Floats) -> Floats:
            return prs.task_jacobian(prs.forward(at, self.table, x), at, self.table)

        change = (jacobian(q + h * v) - jacobian(q - h * v)) / (2.0 * h)
        return now, np.einsum("...ij,...j->...i", change, v)


def joint_rate(machine: ParallelMachine, q: ArrayLike, v: ArrayLike) -> Floats:
    """Joint rates (..., n) at q (..., n) of velocities v (..., n) of the task coordinates."""
    jacobian, _ = machine.task_motion(q, np.zeros_like(q))
    speed = np.asarray(v, dtype=float)[..., None]
    return np.asarray(np.linalg.solve(jacobian, speed)[..., 0], dtype=np.float64)


def joint_motion(
    machine: ParallelMachine, x: ArrayLike, v: ArrayLike, a: ArrayLike
) -> tuple[Floats, Floats, Floats]:
    """Joint positions, rates and accelerations (..., n) of a motion of the task coordinates (..., n)."""
    q = machine.inverse(x)
    rate = joint_rate(machine, q, v)
    jacobian, drift = machine.task_motion(q, rate)
    net = np.asarray(a, dtype=float) - drift
    acceleration = np.linalg.solve(jacobian, net[..., None])[..., 0]
    return q, rate, np.asarray(acceleration, dtype=np.float64)
