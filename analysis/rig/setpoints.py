"""Setpoints: jog with bounded acceleration, moves from rest to rest, and motions out and back."""

from collections.abc import Mapping

import numpy as np

from ...models.motion import polynomial_4567
from ..errors import InputError
from .machine import Floats, Trajectory

# Largest s' and s'' of the 4-5-6-7 polynomial.
STEEPEST = 35.0 / 16.0
SHARPEST = 84.0 * np.sqrt(5.0) / 25.0


class Ramp:
    """Positions (n,) that follow a wanted speed with bounded acceleration."""

    def __init__(self, position: Floats, speed: Floats, acceleration: Floats, dt: float) -> None:
        self.position = np.array(position, dtype=float)
        self.speed = np.array(speed, dtype=float)  # present
        self.wanted = np.zeros_like(self.position)
        self._step = np.asarray(acceleration) * dt
        self._dt = dt

    @property
    def at_rest(self) -> bool:
        """Whether it stands and is to stand."""
        return not (self.speed.any() or self.wanted.any())

    def advance(self) -> tuple[Floats, Floats]:
        """The next sample: position and acceleration, (n,) each."""
        change = np.clip(self.wanted - self.speed, -self._step, self._step)
        self.position = self.position + (self.speed + 0.5 * change) * self._dt
        self.speed = self.speed + change
        return self.position.copy(), change / self._dt


def rest_to_rest(
    start: Floats, end: Floats, speed: Floats, acceleration: Floats, dt: float
) -> tuple[Floats, Floats]:
    """Samples (k, n) of position and acceleration on the straight way, inside both bounds (n,).

    The 4-5-6-7 polynomial in the shortest time that keeps every coordinate within its bounds; the last sample is
    ``end``.
    """
    way = np.asarray(end, dtype=float) - start
    shortest = max(
        float(np.max(STEEPEST * np.abs(way) / speed)),
        float(np.max(np.sqrt(SHARPEST * np.abs(way) / acceleration))),
        dt,
    )
    samples = int(np.ceil(shortest / dt))
    tau = np.arange(1, samples + 1) / samples
    s, _, second = polynomial_4567(tau)
    time = samples * dt
    return start + np.multiply.outer(s, way), np.multiply.outer(second / time**2, way)


def out_and_back(
    name: str, programs: Mapping[str, Floats], rate: float, cycles: int, dt: float
) -> Trajectory:
    """``cycles`` of a program, by its amplitudes (motors,) [unit], out and back by the 4-5-6-7 polynomial.

    InputError for an unknown program or impossible numbers.
    """
    if name not in programs:
        raise InputError("trajectory", f"unknown motion {name!r}", f"one of {', '.join(programs)}")
    if not 0.0 < rate <= 0.05 / dt:
        raise InputError(
            "trajectory", f"rate is {rate} Hz", f"above 0 and at most {0.05 / dt:g} Hz"
        )
    if not 1 <= cycles <= 100:
        raise InputError("trajectory", f"cycles is {cycles}", "1 to 100")
    half = 0.5 / rate
    phase = np.mod(dt * np.arange(round(cycles / (rate * dt))), 2.0 * half)
    s, _, second = polynomial_4567(np.minimum(phase, 2.0 * half - phase) / half)
    return Trajectory(
        name=f"{name} {rate:g} Hz",
        position=np.multiply.outer(s, programs[name]),
        acceleration=np.multiply.outer(second / half**2, programs[name]),
        keys={"note": name, "rate_Hz": rate},
    )
