"""Tracking error of the shafts."""

from typing import Any

from pydrake.systems.framework import LeafSystem

from . import scalars


class TrackingError(LeafSystem):
    """Reference minus measured position, ``e = psi_d - psi`` (Friedlaender 2015, eq. 4.31).

    | port | size | unit |
    |---|---|---|
    | in  `reference` | n | rad or m |
    | in  `position`  | n | as `reference` |
    | out `error`     | n | as `reference` |

    No state, no parameters.
    """

    def __init__(self, size: int) -> None:
        LeafSystem.__init__(self)
        reference = self.DeclareVectorInputPort("reference", size)
        position = self.DeclareVectorInputPort("position", size)
        self.DeclareVectorOutputPort(
            "error",
            size,
            self._error,
            prerequisites_of_calc={reference.ticket(), position.ticket()},
        )

    def _error(self, context: Any, output: Any) -> None:
        reference = scalars.numbered(self, context, 0)
        output.SetFromVector(reference - scalars.numbered(self, context, 1))
