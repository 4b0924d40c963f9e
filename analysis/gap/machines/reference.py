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
