"""Derivative of a sampled signal behind a first-order low-pass."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models import control
from . import scalars


class FilteredDerivative(LeafSystem):
    """Derivative of a sampled signal through F(s) = N s / (N + s)  (Friedlaender 2015, eq. 5.1).

    | port | size | unit |
    |---|---|---|
    | in  `signal`     | n | any |
    | out `derivative` | n | any/s |

    One discrete state per element, the low-passed signal, updated every ``period`` seconds by exact
    discretisation for a held input; zero at first. Numeric parameter ``CUTOFF``: N [rad/s].
    Raises ValueError if ``cutoff`` or ``period`` is not positive.
    """

    CUTOFF = 0

    def __init__(self, size: int, cutoff: float, period: float) -> None:
        LeafSystem.__init__(self)
        self.period = scalars.positive(self, "period", period, "s")
        scalars.declare_parameter(self, [scalars.positive(self, "cutoff", cutoff, "rad/s")])
        self.DeclareDiscreteState(np.zeros(size))
        self.DeclareVectorInputPort("signal", size)
        self.DeclareVectorOutputPort("derivative", size, self._derivative)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._low_pass)

    def _derivative(self, context: Any, output: Any) -> None:
        signal, memory, cutoff = self._at(context)
        output.SetFromVector(control.filtered_derivative(signal, memory, cutoff))

    def _low_pass(self, context: Any, discrete_state: Any) -> None:
        signal, memory, cutoff = self._at(context)
        decay = control.derivative_decay(cutoff, self.period)
        discrete_state.set_value(control.low_pass(signal, memory, decay))

    def _at(self, context: Any) -> tuple[Any, Any, float]:
        return (
            scalars.numbered(self, context, 0),
            context.get_discrete_state_vector().value(),
            context.get_numeric_parameter(self.CUTOFF)[0],
        )
