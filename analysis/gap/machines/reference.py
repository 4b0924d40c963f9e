"""Rates and accelerations of a logged reference."""

import numpy as np
from numpy.typing import NDArray
from scipy.signal import savgol_filter

WINDOW = 15  # samples; wide enough for references printed with six decimals
ORDER = 4


def derivatives(
    reference: NDArray[np.float64], dt: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """First and second derivative (samples, n) by local polynomials (Savitzky-Golay)."""
    rate = savgol_filter(reference, WINDOW, ORDER, deriv=1, delta=dt, axis=0)
    acceleration = savgol_filter(reference, WINDOW, ORDER, deriv=2, delta=dt, axis=0)
    return np.ascontiguousarray(rate), np.ascontiguousarray(acceleration)


def uneven_derivatives(
    reference: NDArray[np.float64], t: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """First and second derivative (samples, n) of a reference sampled at times (samples,) [s]."""
    dt = float(np.median(np.diff(t)))
    even = np.arange(t[0], t[-1] + 0.5 * dt, dt)
    resampled = np.column_stack([np.interp(even, t, column) for column in reference.T])
    found = derivatives(resampled, dt)
    rate, acceleration = (
        np.column_stack([np.interp(t, even, column) for column in d.T]) for d in found
    )
    return rate, acceleration
