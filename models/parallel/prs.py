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

from . import rotation
from .energy import Equations, SpatialMotion, spatial_equations

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
    x = np.asarray(task, dtype=float)
    z, psi, theta = x[..., 0], x[..., 1], x[..., 2]
    across, arms = table.across, table.radius * table.radial
    share, solved = table.planes
    tilted = rotation.platform(psi, theta, 0.0 * psi)
    a, b = (
        np.einsum("k,ki,...ij,kj->...", share, across, tilted, arm)
        for arm in (arms, table.radius * across)
    )
    phi = np.arctan(-a / b)
    turned = rotation.platform(psi, theta, phi)
    reach = np.einsum("...ij,kj->...ki", turned, arms)
    off = np.einsum("ki,...ki->...k", across, reach)
    shift = np.einsum("ik,...k->...i", solved, off)
    position = np.concatenate([shift, z[..., None]], axis=-1)
    return Pose(position, turned, phi, position[..., None, :] + reach)


def inverse(task: ArrayLike, table: Table, modes: tuple[int, int, int] = (-1, -1, -1)) -> Floats:
    """Slider positions (..., 3) [m] at tasks (..., 3) (20); NaN out of reach.

    Mode -1 has that bar lead ahead of its slider, +1 has it trail behind.
    """
    to_joint = pose(task, table).joints - table.start * table.radial
    ahead = np.einsum("ki,...ki->...k", table.along, to_joint)
    square = np.einsum("...ki,...ki->...k", to_joint, to_joint)
    with np.errstate(invalid="ignore"):
        return np.asarray(ahead + np.array(modes) * np.sqrt(ahead**2 - square + table.bar**2))


def bars(at: Pose, sliders: ArrayLike, table: Table) -> Floats:
    """Vectors l_i (..., 3, 3) from slider to joint [m]."""
    q = np.asarray(sliders, dtype=float)
    return np.asarray(at.joints - table.start * table.radial - q[..., None] * table.along)


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
    q = np.asarray(sliders, dtype=float)
    level = np.array([table.home, 0.0, 0.0])
    x = np.broadcast_to(level if guess is None else np.asarray(guess, dtype=float), q.shape).copy()
    error = np.full(q.shape, np.nan)
    with np.errstate(all="ignore"):
        for _ in range(30):
            error = q - inverse(x, table)
            if not np.nanmax(np.abs(error), initial=0.0) > tolerance:
                break
            x = x + np.einsum("...ij,...j->...i", task_jacobian(x, q - error, table), error)
            x[np.abs(x).max(axis=-1) > 10.0] = np.nan
    x[~(np.abs(error).max(axis=-1) <= max(tolerance, 1e-12))] = np.nan
    return x


class Twist(NamedTuple):
    """Velocity and angular velocity of the platform, world axes, per slider rate."""

    jacobian: Floats  # (..., 6, 3)
    constraint: Floats  # left-hand matrix of (3), six rows without unit (..., 6, 6)


def twist(at: Pose, sliders: ArrayLike, table: Table) -> Twist:
    """Solve (3) for the platform; rows are scaled by bar length and joint radius."""
    l = bars(at, sliders, table)  # noqa: E741
    arms = at.joints - at.position[..., None, :]
    across = np.broadcast_to(table.across, l.shape)
    left = np.concatenate(
        [
            np.concatenate([row, rotation.cross(arms, row)], axis=-1)
            for row in (l / table.bar, across)
        ],
        axis=-2,
    )
    right = np.zeros((*l.shape[:-2], 6, 3))
    driven = np.einsum("...ki,ki->...k", l, table.along) / table.bar
    right[..., (0, 1, 2), (0, 1, 2)] = driven
    left_scaled = left * np.array([1.0] * 3 + [1.0 / table.radius] * 3)
    return Twist(_solve(left, right), left_scaled)


def task_jacobian(task: ArrayLike, sliders: ArrayLike, table: Table) -> Floats:
    """Rates of (z, psi, theta) per slider rate (..., 3, 3)."""
    x = np.asarray(task, dtype=float)
    at = pose(x, table)
    j = twist(at, sliders, table).jacobian
    rates = rotation.platform_rates(x[..., 1], x[..., 2], at.phi)
    body = np.einsum("...ji,...jk->...ik", at.rotation, j[..., 3:, :])
    angles = _solve(rates, body)
    return np.concatenate([j[..., 2:3, :], angles[..., :2, :]], axis=-2)


def motion(task: ArrayLike, rates: ArrayLike, table: Table) -> SpatialMotion:
    """Motion of BODIES at tasks (..., 3) and slider rates (..., 3) [m/s]."""
    x, v = np.asarray(task, dtype=float), np.asarray(rates, dtype=float)
    at, q = pose(x, table), inverse(x, table)
    l = bars(at, q, table)  # noqa: E741
    normal = rotation.cross(table.across, l)  # dl / dgamma
    solved = twist(at, q, table)
    moving = np.einsum("...ij,...j->...i", solved.jacobian, v)
    spin = moving[..., 3:]
    arms = at.joints - at.position[..., None, :]
    centripetal = rotation.cross(spin[..., None, :], rotation.cross(spin[..., None, :], arms))
    joint_rows = _point(solved.jacobian[..., None, :, :], arms)
    slide_rows = table.along[:, :, None] * np.eye(3)[:, None, :]
    # gamma' = n . (B' - rho' d) / L^2, and the same for its rate.
    turn_rows = np.einsum("...ki,...kij->...kj", normal, joint_rows - slide_rows) / table.bar**2
    turn = np.einsum("...kj,...j->...k", turn_rows, v)
    inward = turn**2 * table.bar
    along_bar = np.einsum("...ki,...ki->...k", l, centripetal) / table.bar
    sideways = np.einsum("ki,...ki->...k", table.across, centripetal)
    bias = _solve(
        _rows(solved, table), -np.concatenate([along_bar + inward, sideways], axis=-1)[..., None]
    )[..., 0]
    joint_bias = bias[..., None, :3] + rotation.cross(bias[..., None, 3:], arms) + centripetal
    turn_bias = np.einsum("...ki,...ki->...k", normal, joint_bias) / table.bar**2
    return _assemble(
        at, table, (solved.jacobian, bias, spin), (l, normal, turn_rows, turn, turn_bias)
    )


def dynamics(
    sliders: ArrayLike, rates: ArrayLike, table: Table, task: ArrayLike | None = None
) -> Equations:
    """Equations (3.37) in slider forces at positions [m] and rates [m/s] (..., 3).

    ``task`` saves the forward problem where the caller has solved it.
    """
    x = forward(sliders, table) if task is None else task
    return spatial_equations(motion(x, rates, table), table.masses, table.inertias, table.weight)


def _assemble(at, table, platform, legs) -> SpatialMotion:  # type: ignore[no-untyped-def]
    twist_rows, bias, spin = platform
    l, normal, turn_rows, turn, turn_bias = legs  # noqa: E741
    batch = l.shape[:-2]
    jacobian = np.zeros((*batch, 7, 6, 3))
    drift, spins = np.zeros((*batch, 7, 6)), np.zeros((*batch, 7, 3))
    slide_rows = table.along[:, :, None] * np.eye(3)[:, None, :]
    half = 0.5 * normal
    jacobian[..., :3, :3, :] = slide_rows + half[..., :, None] * turn_rows[..., None, :]
    jacobian[..., :3, 3, :] = turn_rows
    drift[..., :3, :3] = half * turn_bias[..., None] - 0.5 * l * (turn**2)[..., None]
    drift[..., :3, 3] = turn_bias
    spins[..., :3, 0] = turn
    arm = np.einsum("...ij,j->...i", at.rotation, np.array(table.platform_centre))
    jacobian[..., 3, :3, :] = _point(twist_rows, arm)
    drift[..., 3, :3] = (
        bias[..., :3]
        + rotation.cross(bias[..., 3:], arm)
        + rotation.cross(spin, rotation.cross(spin, arm))
    )
    into_body = np.swapaxes(at.rotation, -1, -2)
    jacobian[..., 3, 3:, :] = into_body @ twist_rows[..., 3:, :]
    drift[..., 3, 3:] = np.einsum("...ij,...j->...i", into_body, bias[..., 3:])
    spins[..., 3, :] = np.einsum("...ij,...j->...i", into_body, spin)
    jacobian[..., 4:, :3, :] = slide_rows
    return SpatialMotion(jacobian, drift, spins)


def _rows(solved: Twist, table: Table) -> Floats:
    return solved.constraint * np.array([1.0] * 3 + [table.radius] * 3)


def _point(twist_rows: Floats, arm: Floats) -> Floats:
    """Velocity rows (..., 3, n) of a point at ``arm`` (..., 3) from the reference point."""
    turning = rotation.cross(np.swapaxes(twist_rows[..., 3:, :], -1, -2), arm[..., None, :])
    return np.asarray(twist_rows[..., :3, :] + np.swapaxes(turning, -1, -2))


def _solve(left: Floats, right: Floats) -> Floats:
    """As ``numpy.linalg.solve``, with NaN for singular matrices and for matrices of NaN."""
    usable = np.asarray(np.isfinite(left).all(axis=(-1, -2)))
    usable &= np.abs(np.linalg.det(np.where(usable[..., None, None], left, 0.0))) > 0.0
    safe = np.where(usable[..., None, None], left, np.eye(left.shape[-1]))
    return np.asarray(np.where(usable[..., None, None], np.linalg.solve(safe, right), np.nan))
