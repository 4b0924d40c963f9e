"""Incremental encoder: the position rounded to whole counts (Friedlaender 2015, section 5.1.4)."""

import numpy as np

from .friction import Scalar


def resolution(bits: int) -> float:
    """Angle of one count [rad] of an encoder with ``bits`` bits per turn; 13 on the C-drive."""
    if bits < 1:
        raise ValueError(f"bits is {bits}; expected a positive number of bits per turn")
    return 2.0 * np.pi / 2**bits


def read(angle: Scalar, lsb: Scalar) -> Scalar:
    """Nearest multiple of the count ``lsb`` [rad or m]; the angle itself for ``lsb = 0``."""
    return lsb * np.floor(angle / lsb + 0.5) if lsb > 0.0 else angle
