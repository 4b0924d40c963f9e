"""Delay by one sample."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from . import scalars


class UnitDelay(LeafSystem):
    """The signal of one sample ago, 1/z: ``delayed[k] = signal[k-1]``, zero at k = 0.

    | port | size | unit |
    |---|---|---|
    | in  `signal`  | n | any |
    | out `delayed` | n | as `signal` |

    One discrete state per element, updated every ``period`` seconds; the output has no direct
    feedthrough, so it opens an algebraic loop. Raises ValueError if ``period`` is not positive.
    Source: Friedlaender 2015, Fig. 4-2.
    """

    def __init__(self, size: int, period: float) -> None:
        LeafSystem.__init__(self)
        self.DeclareDiscreteState(np.zeros(size))
        self.DeclareVectorInputPort("signal", size)
        self.DeclareVectorOutputPort(
            "delayed", size, self._delayed, prerequisites_of_calc={self.xd_ticket()}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            scalars.positive(self, "period", period, "s"), 0.0, self._keep
        )

    def _delayed(self, context: Any, output: Any) -> None:
        output.SetFromVector(context.get_discrete_state_vector().value())

    def _keep(self, context: Any, discrete_state: Any) -> None:
        discrete_state.set_value(scalars.signal(self, context, "signal"))
