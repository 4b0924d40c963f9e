"""Motion programs of the C-drive benchmark (Friedlaender 2015, section 5.1.4).

A program is one out-and-back cycle per motor, the 4-5-6-7 polynomial s(tau) of eq. (5.3) scaled by
the coefficients of Table 5-2. The thesis prints the cycle as s(t) up to t_max/2 (5.4a) with
t = tau*t_max (5.4b); read literally s would reach 1 at t_max only. The polynomial runs over half a
cycle, so t = tau*t_max/2 (misprint, see ERRATA). Angles in rad, times in s, rates in Hz.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray


def polynomial_4567(tau: Any) -> tuple[Any, Any, Any]:
    """Eq. (5.3) with its first two derivatives by ``tau`` in [0, 1]: (s, s', s'')."""
    s = tau**4 * (35.0 + tau * (-84.0 + tau * (70.0 - 20.0 * tau)))
    ds = tau**3 * (140.0 + tau * (-420.0 + tau * (420.0 - 140.0 * tau)))
    dds = tau**2 * (420.0 + tau * (-1680.0 + tau * (2100.0 - 840.0 * tau)))
    return s, ds, dds


def cycle(t: Any, rate: float) -> tuple[Any, Any, Any]:
    """Eq. (5.4), out and back: progress (0 to 1), its rate [1/s] and acceleration [1/s^2] at ``t`` [s], float or array."""
    half = 0.5 / rate
    phase = t % (2.0 * half)
    s, ds, dds = polynomial_4567((half - abs(half - phase)) / half)
    return s, (1.0 - 2.0 * (phase > half)) * ds / half, dds / half**2


@dataclass(frozen=True, kw_only=True)
class MotionProgram:
    """One out-and-back cycle per motor, repeated without pause.

    Raises ValueError if the rate is not positive.
    """

    name: str
    amplitude_L: float  # alpha_L of Table 5-2 [rad]
    amplitude_R: float  # alpha_R of Table 5-2 [rad]
    rate: float  # cycles per second [Hz]

    def __post_init__(self) -> None:
        if not self.rate > 0.0:
            raise ValueError(
                f"motion {self.name!r}: rate is {self.rate} Hz; expected a positive number of "
                "cycles per second"
            )

    def sample(
        self, t: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Motor angles, rates and accelerations at times ``t`` [s]: arrays (..., 2), (L, R)."""
        amplitude = np.array([self.amplitude_L, self.amplitude_R])
        position, rate, acceleration = (
            np.multiply.outer(progress, amplitude)
            for progress in cycle(np.asarray(t, dtype=float), self.rate)
        )
        return position, rate, acceleration


# Table 5-2: (alpha_L, alpha_R) in rad.
C_DRIVE_MOTIONS: dict[str, tuple[float, float]] = {
    "translation": (-20.0 * np.pi / 3.0, 20.0 * np.pi / 3.0),
    "rotation": (np.pi, np.pi),
    "helical": (-17.0 * np.pi / 6.0, 23.0 * np.pi / 6.0),
}


def c_drive_motion(name: str, rate: float) -> MotionProgram:
    """Benchmark motion ``name`` of Table 5-2 at ``rate`` Hz; ValueError for an unknown name."""
    if name not in C_DRIVE_MOTIONS:
        raise ValueError(
            f"unknown motion {name!r}; expected one of {', '.join(sorted(C_DRIVE_MOTIONS))}"
        )
    left, right = C_DRIVE_MOTIONS[name]
    return MotionProgram(name=name, amplitude_L=left, amplitude_R=right, rate=rate)
