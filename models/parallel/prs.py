r"""Tables on three P-R-S legs, each in a vertical plane: kinematics and dynamics in the slider positions.

Leg i lies in the plane of the radial direction :math:`e_i` and z. Its slider is at :math:`c_i + \rho_i d`, its bar
leads to the joint :math:`B_i = p + R b_i` of the platform, at slope :math:`\gamma_i`:

1. :math:`B_i = c_i + \rho_i d + l_i, \quad l_i = L (-\cos\gamma_i\, e_i + \sin\gamma_i\, z)`
2. :math:`t_i \cdot B_i = 0, \quad t_i = z \times e_i`: the parasitic x, y and phi of the platform follow from z, psi, theta
3. :math:`l_i \cdot \dot B_i = (l_i \cdot d) \dot\rho_i,\ t_i \cdot \dot B_i = 0`: six equations for the platform's velocity

(1)-(3) hold for sliders of any direction: vertical in the 2PRU-1PRS table, radial in the 3-PRS. Universal for
spherical joints changes no motion: they only overconstrain. Tasks are (z, psi, theta) with R = R_y(theta) R_x(psi)
R_z(phi). Source: Roldan, section 4.2, appendix B.2; Ruiz et al. 2016, eqs. (1)-(20). Leading axes are a batch.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import leg_kernels
from .energy import Equations, SpatialMotion, spatial_equations
from .legs import Legs

Floats = NDArray[np.float64]
Z = np.array([0.0, 0.0, 1.0])

BODIES = ("bar1", "bar2", "bar3", "platform", "carriage1", "carriage2", "carriage3")


@dataclass(frozen=True, kw_only=True)
class Table:
    """Geometry and inertia of a table. Raises ValueError for lengths or masses out of range."""

    azimuths: tuple[float, float, float]  # of the leg planes, about z from x [rad]
    start: float  # radius of the sliders at position zero [m]
    slide: tuple[float, float]  # direction of the sliders, radial and z, of length one
    bar: float  # L [m]
    radius: float  # of the joints on the platform [m]
    home: float  # height z of the platform from which the forward problem starts [m]
    bar_mass: float  # [kg]
    bar_inertia: float  # about the revolute axis, at the centre [kg m^2]
    platform_mass: float  # [kg]
    platform_inertia: tuple[float, float, float, float, float, float]  # xx yy zz xy xz yz [kg m^2]
    carriage_mass: float = 0.0  # of each slider [kg]
    platform_centre: tuple[float, float, float] = (0.0, 0.0, 0.0)  # in the platform's frame [m]
    weight: float = 9.81  # gravity along -z [m/s^2]

    def __post_init__(self) -> None:
        for name in ("start", "bar", "radius"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; expected a length above 0 m")
        for name in ("bar_mass", "bar_inertia", "platform_mass", "carriage_mass"):
            if getattr(self, name) < 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; expected at least 0")
        if abs(np.hypot(*self.slide) - 1.0) > 1e-12:
            raise ValueError(f"slide is {self.slide}; expected a direction of length 1")

    @cached_property
    def radial(self) -> Floats:
        """Directions e_i (3, 3)."""
        a = np.array(self.azimuths)
        return np.stack([np.cos(a), np.sin(a), 0.0 * a], axis=-1)

    @cached_property
    def across(self) -> Floats:
        """Revolute axes t_i (3, 3)."""
        return np.cross(Z, self.radial)

    @cached_property
    def along(self) -> Floats:
        """Slider directions d_i (3, 3)."""
        return self.slide[0] * self.radial + self.slide[1] * Z

    @cached_property
    def planes(self) -> tuple[Floats, Floats]:
        """Combination (3,) of the leg planes that x and y drop out of, and x and y (2, 3) by what they lack."""
        across = self.across
        solved = np.asarray(-np.linalg.pinv(across[:, :2]), dtype=np.float64)
        return np.cross(across[:, 0], across[:, 1]), solved

    @cached_property
    def legs(self) -> Legs:
        """What the compiled loops take."""
        share, solved = self.planes
        return Legs(
            *(self.radial, self.along, self.across, share, solved),
            *(float(self.start), float(self.bar), float(self.radius)),
            np.array(self.platform_centre, dtype=float),
        )

    @property
    def masses(self) -> Floats:
        """Of BODIES (7,) [kg]."""
        return np.array([self.bar_mass] * 3 + [self.platform_mass] + [self.carriage_mass] * 3)

    @property
    def inertias(self) -> Floats:
        """Of BODIES (7, 6) [kg m^2]; of a bar only the one about its revolute axis, x, enters."""
        out = np.zeros((7, 6))
        out[:3, 0], out[3] = self.bar_inertia, self.platform_inertia
        return out


class Pose(NamedTuple):
    """Pose of the platform and bars of the legs."""

    position: Floats  # p (..., 3) [m]
    rotation: Floats  # R (..., 3, 3)
    phi: Floats  # parasitic rotation (...) [rad]
    joints: Floats  # B_i (..., 3, 3) [m]


def pose(task: ArrayLike, table: Table) -> Pose:
    """Pose at tasks (..., 3) of z [m], psi and theta [rad]; x, y and phi from the leg planes (2)."""
    batch, x = _flat(task)
    count = len(x)
    found = Pose(
        np.empty((count, 3)), np.empty((count, 3, 3)), np.empty(count), np.empty((count, 3, 3))
    )
    leg_kernels.pose_all(x, table.legs, *found)
    return Pose(*(part.reshape(batch + part.shape[1:]) for part in found))


def inverse(task: ArrayLike, table: Table, modes: tuple[int, int, int] = (-1, -1, -1)) -> Floats:
    """Slider positions (..., 3) [m] at tasks (..., 3) (20); NaN out of reach.

    Mode -1 has that bar lead ahead of its slider, +1 has it trail behind.
    """
    batch, x = _flat(task)
    out = np.empty_like(x)
    leg_kernels.inverse_all(x, table.legs, np.array(modes, dtype=float), out)
    return out.reshape(*batch, 3)


def bars(at: Pose, sliders: ArrayLike, table: Table) -> Floats:
    """Vectors l_i (..., 3, 3) from slider to joint [m]."""
    batch, q = _flat(sliders)
    out = np.empty((len(q), 3, 3))
    leg_kernels.bars_all(np.ascontiguousarray(at.joints).reshape(-1, 3, 3), q, table.legs, out)
    return out.reshape(*batch, 3, 3)


def slopes(at: Pose, sliders: ArrayLike, table: Table) -> Floats:
    """Slopes gamma_i (..., 3) of the bars over the base [rad]."""
    l = bars(at, sliders, table)  # noqa: E741
    return np.arctan2(l[..., 2], -np.einsum("ki,...ki->...k", table.radial, l))


def forward(
    sliders: ArrayLike, table: Table, guess: ArrayLike | None = None, tolerance: float = 1e-13
) -> Floats:
    """Tasks (..., 3) at slider positions (..., 3) [m], by Newton from ``guess`` (default: home, level).

    NaN where it does not converge: out of reach, or beyond a singularity.
    """
    batch, q = _flat(sliders)
    level = np.array([table.home, 0.0, 0.0])
    start = level if guess is None else np.asarray(guess, dtype=float)
    x = np.broadcast_to(start, (*batch, 3)).reshape(-1, 3).copy()
    leg_kernels.forward_all(q, table.legs, tolerance, x)
    return x.reshape(*batch, 3)


class Twist(NamedTuple):
    """Velocity and angular velocity of the platform, world axes, per slider rate."""

    jacobian: Floats  # (..., 6, 3)
    constraint: Floats  # left-hand matrix of (3), six rows without unit (..., 6, 6)


def twist(at: Pose, sliders: ArrayLike, table: Table) -> Twist:
    """Solve (3) for the platform; rows are scaled by bar length and joint radius."""
    batch, q = _flat(sliders)
    jacobian, constraint = np.empty((len(q), 6, 3)), np.empty((len(q), 6, 6))
    position = np.ascontiguousarray(at.position).reshape(-1, 3)
    joints = np.ascontiguousarray(at.joints).reshape(-1, 3, 3)
    leg_kernels.twist_all(position, joints, q, table.legs, jacobian, constraint)
    scaled = constraint * np.array([1.0] * 3 + [1.0 / table.radius] * 3)
    return Twist(jacobian.reshape(*batch, 6, 3), scaled.reshape(*batch, 6, 6))


def task_jacobian(task: ArrayLike, sliders: ArrayLike, table: Table) -> Floats:
    """Rates of (z, psi, theta) per slider rate (..., 3, 3)."""
    batch, x = _flat(task)
    _, q = _flat(sliders)
    out = np.empty((len(x), 3, 3))
    leg_kernels.jacobian_all(x, q, table.legs, out)
    return out.reshape(*batch, 3, 3)


def motion(task: ArrayLike, rates: ArrayLike, table: Table) -> SpatialMotion:
    """Motion of BODIES at tasks (..., 3) and slider rates (..., 3) [m/s]."""
    task, rates = np.broadcast_arrays(np.asarray(task, dtype=float), np.asarray(rates, dtype=float))
    batch, x = _flat(task)
    _, v = _flat(rates)
    count = len(x)
    found = SpatialMotion(
        np.zeros((count, 7, 6, 3)), np.zeros((count, 7, 6)), np.zeros((count, 7, 3))
    )
    leg_kernels.motion_all(x, v, table.legs, *found)
    return SpatialMotion(*(part.reshape(batch + part.shape[1:]) for part in found))


def dynamics(
    sliders: ArrayLike, rates: ArrayLike, table: Table, task: ArrayLike | None = None
) -> Equations:
    """Equations (3.37) in slider forces at positions [m] and rates [m/s] (..., 3).

    ``task`` saves the forward problem where the caller has solved it.
    """
    x = forward(sliders, table) if task is None else task
    return spatial_equations(motion(x, rates, table), table.masses, table.inertias, table.weight)


def _flat(vectors: ArrayLike) -> tuple[tuple[int, ...], Floats]:
    """The batch's shape, and its vectors (..., 3) as one contiguous array (batch, 3)."""
    values = np.ascontiguousarray(vectors, dtype=float)
    return values.shape[:-1], values.reshape(-1, 3)
