"""Paths of a tool: position, speed and acceleration over time along a line or a circle, or from pose to pose.

The length along a line or circle follows a trapezoid of speed: constant acceleration up to the feed, constant feed,
and the same down. Lengths in m, times in s. Poses may mix m and rad: a polynomial leads from one to the other.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .motion import polynomial_4567

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Trapezoid:
    """Length along a path; a length too short for the feed makes a triangle. ValueError unless positive."""

    length: float  # [m]
    feed: float  # [m/s]
    acceleration: float  # [m/s^2]

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value > 0.0:
                raise ValueError(f"{name} is {value}; expected a value above 0")

    @property
    def ramp(self) -> float:
        """Time to reach the highest speed [s]."""
        return float(min(self.feed, np.sqrt(self.length * self.acceleration)) / self.acceleration)

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return self.length / (self.acceleration * self.ramp) + self.ramp

    def sample(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Length, speed and acceleration at times t (...) [s]; at rest before and after."""
        t, a, ramp = np.asarray(t, dtype=float), self.acceleration, self.ramp
        up, down = np.clip(t, 0.0, ramp), np.clip(t - (self.duration - ramp), 0.0, ramp)
        level = np.clip(t - ramp, 0.0, self.duration - 2.0 * ramp)
        s = 0.5 * a * up**2 + a * ramp * (level + down) - 0.5 * a * down**2
        rising, falling = (t > 0.0) & (t < ramp), (down > 0.0) & (t < self.duration)
        return s, a * (up - down), a * (rising * 1.0 - falling * 1.0)


@dataclass(frozen=True, kw_only=True)
class Line:
    """Straight from start to end. ValueError where they coincide."""

    start: tuple[float, float]  # [m]
    end: tuple[float, float]  # [m]
    feed: float  # [m/s]
    acceleration: float  # [m/s^2]

    @property
    def profile(self) -> Trapezoid:
        """Length along the line."""
        length = float(np.linalg.norm(np.subtract(self.end, self.start)))
        return Trapezoid(length=length, feed=self.feed, acceleration=self.acceleration)

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return self.profile.duration

    def sample(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration (..., 2) at times t (...) [s]."""
        s, v, a = self.profile.sample(t)
        along = np.subtract(self.end, self.start) / self.profile.length
        return (
            np.asarray(self.start) + s[..., None] * along,
            v[..., None] * along,
            a[..., None] * along,
        )


@dataclass(frozen=True, kw_only=True)
class Circle:
    """Counterclockwise turns from the rightmost point."""

    centre: tuple[float, float]  # [m]
    radius: float  # [m]
    turns: float
    feed: float  # [m/s]
    acceleration: float  # along the circle [m/s^2]

    @property
    def profile(self) -> Trapezoid:
        """Length along the circle."""
        length = 2.0 * np.pi * self.radius * self.turns
        return Trapezoid(length=length, feed=self.feed, acceleration=self.acceleration)

    @property
    def duration(self) -> float:
        """Time from rest to rest [s]."""
        return self.profile.duration

    def sample(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration (..., 2) at times t (...) [s]."""
        s, v, a = (np.asarray(x)[..., None] for x in self.profile.sample(t))
        out = np.concatenate([np.cos(s / self.radius), np.sin(s / self.radius)], axis=-1)
        round_ = np.stack([-out[..., 1], out[..., 0]], axis=-1)
        position = np.asarray(self.centre) + self.radius * out
        return position, v * round_, a * round_ - v**2 / self.radius * out


@dataclass(frozen=True, kw_only=True)
class Poses:
    """From a pose to another and back by the 4-5-6-7 polynomial. ValueError unless the time is positive."""

    start: tuple[float, ...]  # task coordinates [m or rad]
    end: tuple[float, ...]
    duration: float  # of both ways [s]

    def __post_init__(self) -> None:
        if len(self.start) != len(self.end):
            raise ValueError(f"start has {len(self.start)} and end {len(self.end)} coordinates")
        if not self.duration > 0.0:
            raise ValueError(f"duration is {self.duration}; expected a value above 0 s")

    def sample(self, t: ArrayLike) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration (..., n) at times t (...) [s]; at rest before and after."""
        half = 0.5 * self.duration
        at = np.clip(np.asarray(t, dtype=float), 0.0, self.duration)
        back = at > half
        s, ds, dds = polynomial_4567(np.where(back, self.duration - at, at) / half)
        way = np.subtract(self.end, self.start)
        speed = np.where(back, -ds, ds) / half
        return (
            np.asarray(self.start) + np.multiply.outer(s, way),
            np.multiply.outer(speed, way),
            np.multiply.outer(dds / half**2, way),
        )


Path = Line | Circle | Poses
