"""Free parameters of a hypothesis in units of their scales, inside their bounds."""

import numpy as np

from .hypothesis import Hypothesis
from .machine import Array, Machine


class ScaledParameters:
    """Keys (effect, name), scales, and bounds in units of the scales; arrays (free parameters,)."""

    def __init__(self, hypothesis: Hypothesis, machine: Machine) -> None:
        free = hypothesis.free(machine)
        self.hypothesis = hypothesis
        self.keys = tuple((effect, p.name) for effect, p in free)
        self.parameters = [p for _, p in free]
        self.scale = np.array([p.scale for p in self.parameters])
        self.lower = np.array([p.lower for p in self.parameters]) / self.scale
        self.upper = np.array([p.upper for p in self.parameters]) / self.scale

    def steps(self, x: Array, step: float) -> Array:
        """Steps of finite differences at ``x``, back from an upper bound where it is in the way."""
        return np.where(x + step > self.upper, -step, step)

    def inside(self, x: Array) -> Array:
        """``x`` drawn a little into the bounds, where trust-region searches start."""
        margin = 1e-3 * np.minimum(self.upper - self.lower, 1.0)
        return np.clip(x, self.lower + margin, self.upper - margin)
