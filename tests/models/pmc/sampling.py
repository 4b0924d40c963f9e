"""Random postures of the working branch, and how far two joint vectors are apart."""

import numpy as np

from gapscope.models.pmc import limits
from gapscope.models.pmc.geometry import Geometry

PROTOTYPE = Geometry()


def working_joints(n, seed, geometry=PROTOTYPE):
    """Random joints inside the limits of the prototype (2.18, 2.19)."""
    rng = np.random.default_rng(seed)
    safe = limits.elevation_limits(geometry)
    d = rng.uniform(geometry.carriage_min, geometry.carriage_max, (n, 2))
    alpha = rng.uniform(safe.safe_min, safe.safe_max, (n, 2))
    return np.column_stack([d, alpha[:, 0], np.pi / 2 - alpha[:, 1]])


def distance(a, b):
    """Largest difference, angles theta1 and theta2 of joints compared on the circle."""
    difference = a - b
    difference[..., 2:] = np.angle(np.exp(1j * difference[..., 2:]))
    return np.abs(difference).max()
