r"""The industry's test cycle for Schoenflies-motion robots, as printed and rounded by Lame curves.

1. up 25 mm, 300 mm across with a half turn, down 25 mm, and the same way back (Friedlaender 2015, Fig. 2-2);
   segments interpolated by the 4-5-6-7 polynomial (5.3) in 350, 1000 and 350 ms (5.2.3): 0.294 Hz.
2. smooth: the corners are quarters of the Lame curve
   :math:`|\xi/a|^3 + |\eta/b|^3 = 1`, whose curvature vanishes at both ends, and one 4-5-6-7 polynomial runs along
   the arc in each direction; the turn follows the way across. (Gauthier, Angeles and Nokleby 2008 choose
   the curve; the corner sizes here are ours.)

Poses (x, y, z, phi) in m and rad, times in s.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..motion import polynomial_4567

Floats = NDArray[np.float64]
Motion = tuple[Floats, Floats, Floats]  # poses, rates, accelerations, each (..., 4)


@dataclass(frozen=True, kw_only=True)
class Placement:
    """Where a cycle is performed; ``direction`` from +x towards +y."""

    x: float  # middle of the way across [m]
    y: float  # [m]
    z: float  # lower end [m]
    phi: float  # screw angle in the middle of the turn [rad]
    direction: float  # of the way across [rad]


@dataclass(frozen=True, kw_only=True)
class IndustryCycle:
    """The printed cycle (1), repeated without pause. Raises ValueError if a size or time is not positive."""

    placement: Placement
    lift: float = 0.025  # [m]
    travel: float = 0.300  # [m]
    turn: float = np.pi  # along the travel, negative to turn the other way [rad]
    lift_time: float = 0.350  # [s]
    travel_time: float = 1.000  # [s]

    def __post_init__(self) -> None:
        for name in ("lift", "travel", "lift_time", "travel_time"):
            if not getattr(self, name) > 0.0:
                raise ValueError(
                    f"cycle: {name} is {getattr(self, name)}; expected a positive number"
                )

    @property
    def period(self) -> float:
        """Time of one cycle [s]."""
        return 2.0 * (2.0 * self.lift_time + self.travel_time)

    def sample(self, t: ArrayLike) -> Motion:
        """Poses, rates and accelerations at times ``t``."""
        clock, backwards = _there_and_back(t, self.period)
        lifted, fell = self.lift_time, self.lift_time + self.travel_time
        up = _ramp(clock, 0.0, self.lift_time)
        across = _ramp(clock, lifted, self.travel_time)
        down = _ramp(clock, fell, self.lift_time)
        height = tuple(self.lift * (a - b) for a, b in zip(up, down))
        way = tuple(self.travel * a for a in across)
        return _place(way, height, backwards, self)


@dataclass(frozen=True, kw_only=True)
class LameCycle:
    """The rounded cycle (2). Raises ValueError if the corners do not fit into the cycle."""

    placement: Placement
    lift: float = 0.025  # [m]
    travel: float = 0.300  # [m]
    turn: float = np.pi  # along the travel [rad]
    time: float = 1.700  # one way [s]
    corner_across: float = 0.075  # a [m]
    corner_up: float = 0.025  # b [m]

    def __post_init__(self) -> None:
        for name in ("lift", "travel", "time", "corner_across", "corner_up"):
            if not getattr(self, name) > 0.0:
                raise ValueError(
                    f"cycle: {name} is {getattr(self, name)}; expected a positive number"
                )
        if self.corner_up > self.lift or 2.0 * self.corner_across > self.travel:
            raise ValueError(
                f"cycle: a corner of {self.corner_across} m by {self.corner_up} m does not fit; "
                f"expected at most {self.travel / 2} m by {self.lift} m"
            )

    @property
    def period(self) -> float:
        """Time of one cycle [s]."""
        return 2.0 * self.time

    def sample(self, t: ArrayLike) -> Motion:
        """Poses, rates and accelerations at times ``t``."""
        clock, backwards = _there_and_back(t, self.period)
        length = self._path.length
        s, ds, dds = (
            length * value / self.time**order
            for order, value in enumerate(polynomial_4567(clock / self.time))
        )
        (way, way1, way2), (height, height1, height2) = self._path.at(s)
        return _place(
            (way, way1 * ds, way2 * ds**2 + way1 * dds),
            (height, height1 * ds, height2 * ds**2 + height1 * dds),
            backwards,
            self,
        )

    @cached_property
    def _path(self) -> "_RoundedPath":
        return _RoundedPath(self.lift, self.travel, self.corner_across, self.corner_up)


class _RoundedPath:
    """Up, Lame corner, across, Lame corner, down, by arc length."""

    def __init__(self, lift: float, travel: float, a: float, b: float) -> None:
        self.travel, self.lift, self.a, self.b = travel, lift, a, b
        self.omega = np.linspace(0.0, np.pi / 2, 8193)
        speed = np.hypot(*self._curve(self.omega)[1])
        middle = np.hypot(*self._curve(0.5 * (self.omega[1:] + self.omega[:-1]))[1])
        simpson = np.diff(self.omega) * (speed[1:] + 4.0 * middle + speed[:-1]) / 6.0
        self.arc = np.concatenate([[0.0], np.cumsum(simpson)])
        self.straight_up = lift - b
        self.half_across = 0.5 * travel - a
        self.length = 2.0 * (self.straight_up + self.arc[-1] + self.half_across)

    def at(self, s: Floats) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
        """Way and height with two derivatives by arc length; the second half mirrors the first."""
        mirrored = s > 0.5 * self.length
        (way, way1, way2), (height, height1, height2) = self._first_half(
            np.where(mirrored, self.length - s, s)
        )
        return (
            (np.where(mirrored, self.travel - way, way), way1, np.where(mirrored, -way2, way2)),
            (height, np.where(mirrored, -height1, height1), height2),
        )

    def _first_half(self, s: Floats) -> tuple[tuple[Floats, ...], tuple[Floats, ...]]:
        corner = s - self.straight_up
        across = corner - self.arc[-1]
        omega = np.interp(corner, self.arc, self.omega)
        point, first, second = self._curve(omega)
        speed2 = first[0] ** 2 + first[1] ** 2
        rate = 1.0 / np.sqrt(speed2)  # of omega by arc length
        bend = -(first[0] * second[0] + first[1] * second[1]) / speed2**2
        where = [corner < 0.0, across > 0.0]
        one, zero = np.ones_like(s), np.zeros_like(s)
        way = (
            np.select(where, [zero, self.a + across], point[0]),
            np.select(where, [zero, one], first[0] * rate),
            np.select(where, [zero, zero], second[0] * rate**2 + first[0] * bend),
        )
        height = (
            np.select(where, [s, self.lift * one], self.straight_up + point[1]),
            np.select(where, [one, zero], first[1] * rate),
            np.select(where, [zero, zero], second[1] * rate**2 + first[1] * bend),
        )
        return way, height

    def _curve(self, omega: Floats) -> tuple[tuple[Floats, Floats], ...]:
        """Corner from (0, 0) up to (a, b) and its derivatives by the polar angle about (a, 0)."""
        c, s = np.clip(np.cos(omega), 0.0, 1.0), np.sin(omega)
        cube = (c / self.a) ** 3 + (s / self.b) ** 3
        cube1 = 3.0 * c * s * (s / self.b**3 - c / self.a**3)
        cube2 = 3.0 * ((2.0 * s * c**2 - s**3) / self.b**3 + (2.0 * c * s**2 - c**3) / self.a**3)
        radius = cube ** (-1.0 / 3.0)
        radius1 = -cube1 * radius**4 / 3.0
        radius2 = -cube2 * radius**4 / 3.0 - 4.0 / 3.0 * cube1 * radius**3 * radius1
        return (
            (self.a - radius * c, radius * s),
            (radius * s - radius1 * c, radius1 * s + radius * c),
            (
                2.0 * radius1 * s + radius * c - radius2 * c,
                2.0 * radius1 * c - radius * s + radius2 * s,
            ),
        )


def _there_and_back(t: ArrayLike, period: float) -> tuple[Floats, NDArray[np.bool_]]:
    phase = np.mod(np.asarray(t, dtype=float), period)
    backwards = phase > 0.5 * period
    return np.where(backwards, period - phase, phase), backwards


def _ramp(clock: Floats, start: float, duration: float) -> Motion:
    tau = np.clip((clock - start) / duration, 0.0, 1.0)
    s, ds, dds = polynomial_4567(tau)
    return s, ds / duration, dds / duration**2


def _place(
    way: tuple[Floats, ...],
    height: tuple[Floats, ...],
    backwards: NDArray[np.bool_],
    cycle: IndustryCycle | LameCycle,
) -> Motion:
    """Poses of a motion in the vertical plane of the cycle; rates change sign on the way back."""
    place = cycle.placement
    c, s, turn = np.cos(place.direction), np.sin(place.direction), cycle.turn / cycle.travel
    poses, rates, accelerations = (
        np.stack([w * c, w * s, h, w * turn], axis=-1) for w, h in zip(way, height)
    )
    half = 0.5 * cycle.travel
    start = np.array(
        [place.x - half * c, place.y - half * s, place.z, place.phi - 0.5 * cycle.turn]
    )
    return start + poses, np.where(backwards[..., None], -rates, rates), accelerations
