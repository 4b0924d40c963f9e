r"""Five-bar (5R) linkage in its two crank angles (Roldan, section 4.1 and appendix B.1).

The cranks turn about (-H/2, 0) and (H/2, 0); angles count from +x. The tool lies on rod 2, at or beyond the
joint C of both rods. ``mode`` is the side of C seen from A to B: +1 left, -1 right.

Corrected here: (B.2) second row has l3 for l2; (B.22) is 1 + (...)^2, which solving on the line AB avoids;
(B.25), (B.26) lose the sign of the angle: atan2. Not modelled: the second linkage that keeps the platform level.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from .energy import Floats, Motion

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
    a = machine.crank1 * _along(q[..., 0]) - np.array([0.5 * machine.base, 0.0])
    b = machine.crank4 * _along(q[..., 1]) + np.array([0.5 * machine.base, 0.0])
    c = _intersection(a, b, machine.rod2, machine.rod3, mode)
    angle2, angle3 = _angle(c - a), _angle(c - b)
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
    posture = forward(q, machine, mode)
    one, two, three, four = q[..., 0], posture.angle2, posture.angle3, q[..., 1]
    l1, l2, l3, l4 = machine.crank1, machine.rod2, machine.rod3, machine.crank4
    crossing = np.sin(three - two)
    by2 = _pair(-l1 * np.sin(three - one), l4 * np.sin(three - four)) / (l2 * crossing)[..., None]
    by3 = _pair(-l1 * np.sin(two - one), l4 * np.sin(two - four)) / (l3 * crossing)[..., None]
    w1, w4 = v[..., 0], v[..., 1]
    w2, w3 = (np.einsum("...i,...i->...", row, v) for row in (by2, by3))
    drift2 = (
        l1 * np.cos(three - one) * w1**2
        + l2 * np.cos(three - two) * w2**2
        - l4 * np.cos(three - four) * w4**2
        - l3 * w3**2
    ) / (l2 * crossing)
    drift3 = (
        l1 * np.cos(two - one) * w1**2
        + l2 * w2**2
        - l4 * np.cos(two - four) * w4**2
        - l3 * np.cos(two - three) * w3**2
    ) / (l3 * crossing)
    zero, still = np.zeros_like(one), np.zeros_like(v)
    by1, by4 = still + np.array([1.0, 0.0]), still + np.array([0.0, 1.0])
    crank1, rod2 = (one, w1, by1, zero), (two, w2, by2, drift2)
    rod3, crank4 = (three, w3, by3, drift3), (four, w4, by4, zero)
    r1, r2, r3, r4 = machine.centres
    bodies = [
        _body(crank1, (r1, crank1)),
        _body(rod2, (l1, crank1), (r2, rod2)),
        _body(rod3, (l4, crank4), (r3, rod3)),
        _body(crank4, (r4, crank4)),
        _body(rod2, (l1, crank1), (machine.tool, rod2)),
        _body(crank1),
        _body(crank4),
    ]
    return Motion(*(np.stack(part, axis=-3 + k) for k, part in enumerate(zip(*bodies))))


def _body(turning, *arms):  # type: ignore[no-untyped-def]
    """Rows (3, n) and drift (3,) of a point at the end of arms (length, link), on the link ``turning``."""
    _, _, by, drift = turning
    rows, drifts = np.zeros((*by.shape[:-1], 2, 2)), np.zeros((*by.shape[:-1], 2))
    for length, (angle, rate, link_by, link_drift) in arms:
        along = _along(angle)
        across = np.stack([-along[..., 1], along[..., 0]], axis=-1)
        rows = rows + length * across[..., :, None] * link_by[..., None, :]
        drifts = drifts + length * (across * link_drift[..., None] - along * rate[..., None] ** 2)
    return (
        np.concatenate([rows, by[..., None, :]], axis=-2),
        np.concatenate([drifts, drift[..., None]], axis=-1),
    )


def _intersection(a: Floats, b: Floats, from_a: float, from_b: float, side: int) -> Floats:
    """Point at two distances from a and b (..., 2), left (+1) or right (-1) of the line from a to b."""
    line = b - a
    square = np.einsum("...i,...i->...", line, line)
    with np.errstate(invalid="ignore", divide="ignore"):
        share = 0.5 * (from_a**2 - from_b**2 + square) / square
        height = np.sqrt(from_a**2 / square - share**2)
    left = np.stack([-line[..., 1], line[..., 0]], axis=-1)
    return np.asarray(a + share[..., None] * line + side * height[..., None] * left)


def _pair(first: Floats, second: Floats) -> Floats:
    return np.stack([first, second], axis=-1)


def _along(angle: Floats) -> Floats:
    return np.stack([np.cos(angle), np.sin(angle)], axis=-1)


def _angle(vector: Floats) -> Floats:
    return np.asarray(np.arctan2(vector[..., 1], vector[..., 0]))
