r"""Five-bar (5R) linkage in its two crank angles (Roldan, section 4.1 and appendix B.1).

The cranks turn about (-H/2, 0) and (H/2, 0); angles count from +x. The tool lies on rod 2, at or beyond the
joint C of both rods. ``mode`` is the side of C seen from A to B: +1 left, -1 right.

Corrected here: (B.2) second row has l3 for l2; (B.22) is 1 + (...)^2, which solving on the line AB avoids;
(B.25), (B.26) lose the sign of the angle: atan2. Not modelled: the second linkage that keeps the platform level.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from . import kernels, linkage
from .energy import Equations, Floats, Motion

BODIES = ("crank1", "rod2", "rod3", "crank4", "tool")


@dataclass(frozen=True, kw_only=True)
class FiveBar:
    """Lengths and masses; defaults are the machine of section 4.1. Raises ValueError unless they are positive.

    Printed: base and lengths. Masses are assumed: aluminium square tube 40 x 40 x 2 mm (0.82 kg/m), slender.
    """

    base: float = 0.2  # H, between the crank axes [m]
    crank1: float = 0.6  # l1 [m]
    rod2: float = 0.7  # l2, A to C [m]
    rod3: float = 0.7  # l3, B to C [m]
    crank4: float = 0.6  # l4 [m]
    tool: float = 0.7  # A to the tool along rod 2 [m]
    centres: tuple[float, float, float, float] = (0.3, 0.35, 0.35, 0.3)  # from A0, A, B, B0 [m]
    masses: tuple[float, float, float, float, float] = (0.49, 0.57, 0.57, 0.49, 0.5)  # assumed [kg]
    inertias: tuple[float, float, float, float] = (0.0147, 0.0233, 0.0233, 0.0147)  # [kg m^2]
    rotors: tuple[float, float] = (0.0, 0.0)  # of the actuators, at the cranks [kg m^2]
    weight: float = 0.0  # gravity along -y [m/s^2]; the plane is horizontal

    def __post_init__(self) -> None:
        for name in ("base", "crank1", "rod2", "rod3", "crank4", "tool"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; expected a length above 0 m")
        if min(*self.masses, *self.inertias, *self.rotors) < 0.0:
            raise ValueError("a mass or inertia is negative; expected values of at least 0")

    @property
    def lengths(self) -> tuple[float, float, float, float, float]:
        """H, l1, l2, l3, l4 [m], as ``linkage`` takes them."""
        return self.base, self.crank1, self.rod2, self.rod3, self.crank4

    @cached_property
    def bodies(self) -> Floats:
        """Of BODIES and rotors (7, 6): link from the base, arm along it [m], own link, arm, kg, kg m^2."""
        r1, r2, r3, r4 = self.centres
        arms = (
            (0, 0.0, 0, r1),
            (0, self.crank1, 1, r2),
            (3, self.crank4, 2, r3),
            (3, 0.0, 3, r4),
            (0, self.crank1, 1, self.tool),
            (0, 0.0, 0, 0.0),
            (3, 0.0, 3, 0.0),
        )
        return np.column_stack([arms, self.body_masses, self.body_inertias])

    @property
    def body_masses(self) -> Floats:
        """Of BODIES (5,) and the two rotors, which only turn [kg]."""
        return np.array([*self.masses, 0.0, 0.0])

    @property
    def body_inertias(self) -> Floats:
        """Of BODIES, the tool a point, and the two rotors (7,) [kg m^2]."""
        return np.array([*self.inertias, 0.0, *self.rotors])


class Posture(NamedTuple):
    """Angles of the rods [rad] and position of the tool (..., 2) [m]; NaN where the loop does not close."""

    angle2: Floats
    angle3: Floats
    tool: Floats


def forward(cranks: ArrayLike, machine: FiveBar, mode: int = 1) -> Posture:
    """Posture at crank angles (..., 2) [rad] (B.18-B.27)."""
    q = np.asarray(cranks, dtype=float)
    with np.errstate(invalid="ignore", divide="ignore"):
        angle2, angle3 = linkage.rod_angles(q[..., 0], q[..., 1], *machine.lengths, mode)
    a = machine.crank1 * _along(q[..., 0]) - np.array([0.5 * machine.base, 0.0])
    return Posture(angle2, angle3, a + machine.tool * _along(angle2))


def inverse(tool: ArrayLike, machine: FiveBar, modes: tuple[int, int] = (1, -1)) -> Floats:
    """Crank angles (..., 2) [rad] at tool positions (..., 2) [m]; NaN out of reach.

    ``modes`` are the sides of A and B, seen from their crank axes to the tool and to C.
    """
    p = np.asarray(tool, dtype=float)
    a0 = np.array([-0.5 * machine.base, 0.0])
    a = _intersection(np.broadcast_to(a0, p.shape), p, machine.crank1, machine.tool, modes[0])
    c = a + machine.rod2 / machine.tool * (p - a)
    b = _intersection(np.broadcast_to(-a0, p.shape), c, machine.crank4, machine.rod3, modes[1])
    return np.stack([_angle(a - a0), _angle(b + a0)], axis=-1)


def motion(cranks: ArrayLike, rates: ArrayLike, machine: FiveBar, mode: int = 1) -> Motion:
    """Motion of BODIES and rotors (7) at crank angles and rates (..., 2) (B.13-B.17)."""
    q, v = np.asarray(cranks, dtype=float), np.asarray(rates, dtype=float)
    one, four, w1, w4 = q[..., 0], q[..., 1], v[..., 0], v[..., 1]
    with np.errstate(invalid="ignore", divide="ignore"):  # NaN where the loop does not close
        rods = linkage.rods(one, four, w1, w4, *machine.lengths, mode)
    two, three, by21, by24, by31, by34, drift2, drift3 = rods
    w2, w3, zero = by21 * w1 + by24 * w4, by31 * w1 + by34 * w4, np.zeros_like(one)
    links = (
        (one, w1, zero + 1.0, zero, zero),
        (two, w2, by21, by24, drift2),
        (three, w3, by31, by34, drift3),
        (four, w4, zero, zero + 1.0, zero),
    )
    jacobian, drift = np.zeros((*one.shape, 7, 3, 2)), np.zeros((*one.shape, 7, 3))
    for b, (first, along_first, own, along_own, *_) in enumerate(machine.bodies):
        for link, length in ((int(first), along_first), (int(own), along_own)):
            x1, x4, y1, y4, dx, dy = linkage.arm(length, *links[link])
            jacobian[..., b, 0, :] += _pair(x1, x4)
            jacobian[..., b, 1, :] += _pair(y1, y4)
            drift[..., b, :2] += _pair(dx, dy)
        _, _, by1, by4, turn = links[int(own)]
        jacobian[..., b, 2, :] = _pair(by1, by4)
        drift[..., b, 2] = turn
    return Motion(jacobian, drift)


def equations(cranks: ArrayLike, rates: ArrayLike, machine: FiveBar, mode: int = 1) -> Equations:
    """``energy.equations`` of one posture, crank angles and rates (2,), in a hundredth of the time."""
    q, v, lengths = _posture(cranks, rates, machine, mode)
    return Equations(*kernels.five_bar_equations(q, v, lengths, machine.bodies, machine.weight))


def tool_motion(
    cranks: ArrayLike, rates: ArrayLike, machine: FiveBar, mode: int = 1
) -> tuple[Floats, Floats]:
    """Jacobian (2, 2) and drift (2,) of the tool in one posture, crank angles and rates (2,)."""
    q, v, lengths = _posture(cranks, rates, machine, mode)
    tool = BODIES.index("tool")
    jacobian, drift = kernels.five_bar_motion(q, v, lengths, machine.bodies[tool : tool + 1])
    return jacobian[0, :2], drift[0, :2]


def _posture(
    cranks: ArrayLike, rates: ArrayLike, machine: FiveBar, mode: int
) -> tuple[Floats, ...]:
    """Arguments of the kernels."""
    q, v = np.asarray(cranks, dtype=float), np.asarray(rates, dtype=float)
    return q, v, np.array([*machine.lengths, mode], dtype=float)


def _pair(first: Floats, second: Floats) -> Floats:
    return np.stack([first, second], axis=-1)


def _intersection(a: Floats, b: Floats, from_a: float, from_b: float, side: int) -> Floats:
    """``linkage.apex`` of points (..., 2)."""
    with np.errstate(invalid="ignore", divide="ignore"):
        x, y = linkage.apex(a[..., 0], a[..., 1], b[..., 0], b[..., 1], from_a, from_b, side)
    return _pair(x, y)


def _along(angle: Floats) -> Floats:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _angle(vector: Floats) -> Floats:
    return np.asarray(np.arctan2(vector[..., 1], vector[..., 0]))
