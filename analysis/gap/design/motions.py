"""Candidate motions: vectors of a search to Fourier series inside travel and speed limits.

Every task coordinate moves as S(t), a series of ``harmonics`` sines and cosines whose coefficients
span the null space of zero position, speed and acceleration at the ends of a cycle. A coordinate
that starts at an end of its travel moves as +-S(t)^2, a series of twice the harmonics that never
crosses that end.
"""

import numpy as np
from scipy.linalg import block_diag, null_space

from ....models.fourier_motion import FourierMotion
from ..drive_machine import DriveMachine
from ..machine import Array
from .limits import Limits

HARMONICS = 4
ONE_SIDED = 0.1  # a side with less than this share of the other is not used
SAMPLES = 400  # per cycle, where limits are looked at
GRID = 0.999  # of a limit: what extremes between these samples may add


class Motions:
    """Maps points of the unit cube [-1, 1]^size to motions of all shafts."""

    def __init__(
        self, machine: DriveMachine, limits: Limits, period: float, harmonics: int = HARMONICS
    ) -> None:
        self._machine, self._limits, self._period = machine, limits, period
        k = np.arange(1.0, harmonics + 1)
        # Columns: coefficients (cosine, sine) that keep the ends at rest.
        self._basis = block_diag(null_space([k**2]), null_space([k]))
        self.size = len(machine.task) * self._basis.shape[1]
        self._harmonics = harmonics

    def motion(self, point: Array, cycles: int, name: str = "designed") -> FourierMotion:
        """The motion of a point, as large as the point says but inside travel and speed."""
        machine, limits = self._machine, self._limits
        parts = np.reshape(point, (len(machine.task), -1)) @ self._basis.T
        task = np.array(
            [self._series(p, low, high) for p, low, high in zip(parts, limits.lower, limits.upper)]
        )
        shafts = np.linalg.solve(machine.task_map, task.reshape(len(task), -1)).reshape(task.shape)
        motion = self._build(shafts, cycles, name)
        _, rate, _ = motion.sample(np.linspace(0.0, self._period, SAMPLES))
        peak = float(np.max(np.abs(rate)))
        return scaled(motion, min(1.0, GRID * limits.speed / peak)) if peak > 0.0 else motion

    def _series(self, part: Array, low: float, high: float) -> Array:
        """Coefficients (2, 2 harmonics) of one task coordinate inside its travel."""
        n = self._harmonics
        c, s = part[:n], part[n:]
        if min(-low, high) <= ONE_SIDED * max(-low, high):
            c, s = _squared(c, s)
            if -low > high:
                c, s = -c, -s
        else:
            c, s = np.pad(c, (0, n)), np.pad(s, (0, n))
        value = _values(c, s)
        span = max(high, -low)
        c, s, value = span * c, span * s, span * value
        rooms = [
            GRID * bound / extreme
            for bound, extreme in ((high, value.max()), (low, value.min()))
            if abs(extreme) > 1e-9 * span
        ]
        shrink = min([1.0, *rooms]) if span > 0.0 else 0.0
        return np.array([shrink * c, shrink * s])

    def _build(self, shafts: Array, cycles: int, name: str) -> FourierMotion:
        return FourierMotion(
            name=name,
            period=self._period,
            cycles=cycles,
            cosine=tuple(tuple(map(float, row)) for row in shafts[:, 0]),
            sine=tuple(tuple(map(float, row)) for row in shafts[:, 1]),
        )


def scaled(motion: FourierMotion, factor: float) -> FourierMotion:
    """The same motion, larger or smaller."""
    return FourierMotion(
        name=motion.name,
        period=motion.period,
        cycles=motion.cycles,
        cosine=tuple(tuple(factor * v for v in row) for row in motion.cosine),
        sine=tuple(tuple(factor * v for v in row) for row in motion.sine),
    )


def _squared(c: Array, s: Array) -> tuple[Array, Array]:
    """Coefficients of the square of sum c_k (cos k - 1) + s_k sin k, of twice the harmonics."""
    positive = 0.5 * (c - 1j * s)  # of e^(ikx)
    spectrum = np.concatenate([np.conj(positive)[::-1], [-c.sum()], positive])
    square = np.convolve(spectrum, spectrum)[2 * len(c) + 1 :]  # harmonics 1 to 2 n
    return 2.0 * square.real, -2.0 * square.imag


def _values(c: Array, s: Array) -> Array:
    k = np.arange(1, len(c) + 1)
    phase = np.multiply.outer(2.0 * np.pi * np.arange(SAMPLES) / SAMPLES, k)
    return np.asarray((np.cos(phase) - 1.0) @ c + np.sin(phase) @ s)
