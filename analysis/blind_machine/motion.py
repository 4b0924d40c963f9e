"""The thesis' motion programs: s(tau) = -20 tau^7 + 70 tau^6 - 84 tau^5 + 35 tau^4, out and back.

Friedlaender 2015, eqs. (5.3)-(5.4) and Table 5-2; tau runs over half a cycle.
"""

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

Array = NDArray[np.float64]

STROKE = Polynomial([0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0])
SAMPLE_TIME = 1e-3  # s
FINE_TIME = SAMPLE_TIME / 10  # s between the true positions a clock error is drawn from
AMPLITUDE = {  # left and right screw angle at mid-cycle [rad]
    "translation": (-20 * np.pi / 3, 20 * np.pi / 3),
    "rotation": (np.pi, np.pi),
    "helical": (-17 * np.pi / 6, 23 * np.pi / 6),
}


def out_and_back(rate: float, cycles: int) -> tuple[Array, Array, Array]:
    """Time [s], stroke fraction and its second derivative [1/s^2] of ``cycles`` cycles at ``rate`` Hz."""
    t = np.arange(round(cycles / rate / SAMPLE_TIME)) * np.float64(SAMPLE_TIME)
    half = 0.5 / rate
    tau = 1.0 - np.abs(t % (2 * half) / half - 1.0)
    return t, np.asarray(STROKE(tau)), np.asarray(STROKE.deriv(2)(tau)) / half**2
