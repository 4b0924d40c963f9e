"""Encoders of a machine's motors: whole counts from where they were set."""

import numpy as np
from numpy.typing import ArrayLike

from ...models import encoder
from .machine import Floats


class Encoders:
    """Readings (motors,) of true positions, ``lsb`` () or (motors,) a count; at first they are true."""

    def __init__(self, motors: int, lsb: ArrayLike) -> None:
        self._lsb = np.broadcast_to(np.asarray(lsb, dtype=float), (motors,))
        self._offset = np.zeros(motors)

    def read(self, true: Floats) -> Floats:
        """What they show at true positions (motors,)."""
        return np.array([encoder.read(x, lsb) for x, lsb in zip(true - self._offset, self._lsb)])

    def true(self, shown: Floats) -> Floats:
        """True positions (motors,) of what they show, to half a count."""
        return shown + self._offset

    def preset(self, true: Floats, shown: Floats) -> None:
        """Let them show ``shown`` (motors,) at the true positions, to whole counts."""
        self._offset = true - shown
