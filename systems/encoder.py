"""Incremental encoder on each shaft."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models import encoder
from . import scalars


class Encoder(LeafSystem):
    """Position rounded to whole counts: ``read = lsb floor(angle / lsb + 1/2)``.

    | port | size | unit |
    |---|---|---|
    | in  `angle`    | n | rad or m |
    | out `position` | n | as `angle`, a multiple of the count |

    No state; a sampled controller reads it at its own instants. Numeric parameter ``LSB``: the count
    (n,), 0 for an exact encoder. Raises ValueError if a count is negative or not finite.
    Source: Friedlaender 2015, section 5.1.4; 13 bits on the C-drive.
    """

    LSB = 0

    def __init__(self, size: int, lsb: float) -> None:
        LeafSystem.__init__(self)
        if not 0.0 <= lsb < np.inf:
            raise ValueError(f"Encoder: lsb is {lsb}; expected a count of zero or more [rad or m]")
        scalars.declare_parameter(self, np.full(size, lsb))
        angle = self.DeclareVectorInputPort("angle", size)
        self.DeclareVectorOutputPort(
            "position",
            size,
            self._read,
            prerequisites_of_calc={angle.ticket(), self.all_parameters_ticket()},
        )

    def _read(self, context: Any, output: Any) -> None:
        counts = context.get_numeric_parameter(self.LSB).value()
        angle = scalars.numbered(self, context, 0)
        output.SetFromVector([encoder.read(a, lsb) for a, lsb in zip(angle, counts)])
