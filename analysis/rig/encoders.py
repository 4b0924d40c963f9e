"""Encoders of a machine's motors: whole counts from where they were set."""

import numpy as np

from ...models import encoder
from .machine import Floats


class Encoders:
    """Readings (motors,) of true positions; at first they are true."""

    def __init__(self, motors: int, lsb: float) -> None:
        self._lsb, self._offset = lsb, np.zeros(motors)

    def read(self, true: Floats) -> Floats:
        """What they show at true positions (motors,)."""
        return np.array([encoder.read(value, self._lsb) for value in true - self._offset])

    def true(self, shown: Floats) -> Floats:
        """True positions (motors,) of what they show, to half a count."""
        return shown + self._offset

    def preset(self, true: Floats, shown: Floats) -> None:
        """Let them show ``shown`` (motors,) at the true positions, to whole counts."""
        self._offset = true - shown
