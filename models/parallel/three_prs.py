r"""3-PRS compliant table, sliders radial and inwards (Ruiz et al. 2016, in appendix C of Roldan).

1. parasitic motions      :math:`\phi = \arctan\frac{\sin\psi \sin\theta}{\cos\psi + \cos\theta}`, x (14), y (15)
2. revolute joints        :math:`\alpha_i = \arccos(l_{i0} \cdot s_{i0})` (22)
3. spherical joints       :math:`R_{im,joint} = R_{leg}^T R R_{im} = R_m(\beta_m) R_n(\beta_n) R_l(\beta_l)` (24), (32)

Corrected here: the first entry of (32) is :math:`\cos\beta_n \cos\beta_l`; (33) divides by it. (A.7) has u for v in its third
terms. Distances from the flexures' centres: the rigid body stands for small motions only.

Printed: L, b, alpha, the bars' section and density, the flexures' stiffness. Assumed: a platform of the same alloy,
7.5 mm thick (Table 3) with radius 60 mm, its centre of mass at P, and carriages of 0.3 kg.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import prs

Floats = NDArray[np.float64]

BAR, RADIUS = 0.109215, 0.04791  # L, b [m]
SLOPE = np.deg2rad(45.0)  # alpha in the default position [rad]
DENSITY, SECTION = 2810.0, 0.010  # [kg/m^3], [m]
BAR_MASS = DENSITY * SECTION**2 * BAR  # [kg]
PLATE_RADIUS, PLATE = 0.060, 0.0075  # assumed, measured [m]
PLATE_MASS = DENSITY * np.pi * PLATE_RADIUS**2 * PLATE  # [kg]
TILTING = PLATE_MASS * (3.0 * PLATE_RADIUS**2 + PLATE**2) / 12.0
SPINNING = PLATE_MASS * PLATE_RADIUS**2 / 2.0


@dataclass(frozen=True, kw_only=True)
class Flexures:
    """Stiffness of the passive joints; defaults are printed. Raises ValueError for a negative one."""

    revolute: float = 98.37  # about the hinge [N m/rad]
    bending: float = 32.67  # of a spherical flexure [N m/rad]
    torsion: float = 24.46  # the same, about its bar [N m/rad]

    def __post_init__(self) -> None:
        if min(vars(self).values()) < 0.0:
            raise ValueError(f"stiffnesses are {vars(self)}; expected values of at least 0 N m/rad")


FLEXURES = Flexures()

THREE_PRS = prs.Table(
    azimuths=(0.0, 2.0 * np.pi / 3.0, 4.0 * np.pi / 3.0),
    start=float(RADIUS + BAR * np.cos(SLOPE)),  # a
    slide=(-1.0, 0.0),
    bar=BAR,
    radius=RADIUS,
    home=float(BAR * np.sin(SLOPE)),
    bar_mass=BAR_MASS,
    bar_inertia=BAR_MASS * (BAR**2 + SECTION**2) / 12.0,
    platform_mass=float(PLATE_MASS),
    platform_inertia=(TILTING, TILTING, SPINNING, 0.0, 0.0, 0.0),
    carriage_mass=0.3,
)


class JointAngles(NamedTuple):
    """Angles of the passive joints, per leg (..., 3) [rad]; all beta are zero in the default position."""

    revolute: Floats  # alpha_i
    bending_m: Floats  # beta_m, about the revolute axis
    bending_n: Floats  # beta_n
    torsion: Floats  # beta_l, about the bar


def parasitic(psi: ArrayLike, theta: ArrayLike, radius: float = RADIUS) -> Floats:
    """x, y [m] and phi [rad] (..., 3) at rotations psi, theta [rad] (13)-(15)."""
    psi, theta = np.asarray(psi, dtype=float), np.asarray(theta, dtype=float)
    phi = np.arctan(np.sin(psi) * np.sin(theta) / (np.cos(psi) + np.cos(theta)))
    x = np.cos(theta) * np.cos(phi) + np.sin(psi) * np.sin(theta) * np.sin(phi)
    x = 0.5 * radius * (x - np.cos(psi) * np.cos(phi))
    return np.stack([x, -radius * np.cos(psi) * np.sin(phi), phi], axis=-1)


def joint_angles(task: ArrayLike, table: prs.Table = THREE_PRS) -> JointAngles:
    """Angles of revolute and spherical joints at tasks (..., 3) (22), (33)."""
    at = prs.pose(task, table)
    q = prs.inverse(task, table)
    bar = prs.bars(at, q, table) / table.bar
    level = np.array([table.home, 0.0, 0.0])
    home = prs.pose(level, table)
    bar_home = prs.bars(home, prs.inverse(level, table), table) / table.bar
    leg, on_platform = _frame(bar, table), _frame(bar_home, table)
    turned = np.swapaxes(leg, -1, -2) @ at.rotation[..., None, :, :] @ on_platform
    slope = np.arccos(np.einsum("...ki,ki->...k", bar, table.along))
    return JointAngles(
        slope,
        np.arctan2(-turned[..., 1, 2], turned[..., 2, 2]),
        np.arcsin(turned[..., 0, 2]),
        np.arctan2(-turned[..., 0, 1], turned[..., 0, 0]),
    )


def elastic_energy(
    task: ArrayLike, table: prs.Table = THREE_PRS, flexures: Flexures = FLEXURES
) -> Floats:
    """Energy (...) stored in the flexures [J], linear in their angles."""
    j = joint_angles(task, table)
    revolute = flexures.revolute * (j.revolute - _home_slope(table)) ** 2
    bending = flexures.bending * (j.bending_m**2 + j.bending_n**2)
    return np.asarray(0.5 * np.sum(revolute + bending + flexures.torsion * j.torsion**2, axis=-1))


def elastic_force(
    task: ArrayLike,
    sliders: ArrayLike,
    table: prs.Table = THREE_PRS,
    flexures: Flexures = FLEXURES,
) -> Floats:
    """Slider forces (..., 3) that hold the flexures at tasks and slider positions (..., 3) [N].

    Central differences of the energy by the tasks, steps of 1e-6 m and rad.
    """
    x, step = np.asarray(task, dtype=float), 1e-6
    ahead, behind = (
        elastic_energy(x[..., None, :] + sign * step * np.eye(3), table, flexures)
        for sign in (1.0, -1.0)
    )
    slope = (ahead - behind) / (2.0 * step)
    return np.asarray(np.einsum("...ij,...i->...j", prs.task_jacobian(x, sliders, table), slope))


def _home_slope(table: prs.Table) -> float:
    """Angle between bar and slider with the platform level at home [rad]."""
    level = np.array([table.home, 0.0, 0.0])
    bar = prs.bars(prs.pose(level, table), prs.inverse(level, table), table)[0] / table.bar
    return float(np.arccos(bar @ table.along[0]))


def _frame(bar: Floats, table: prs.Table) -> Floats:
    """Frames (..., 3, 3) of columns m = -t, n = l x m, l (25)-(27)."""
    m = np.broadcast_to(-table.across, bar.shape)
    return np.stack([m, np.cross(bar, m), bar], axis=-1)
