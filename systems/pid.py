"""Ideal PID controller."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import LeafSystem

from ..models import control
from . import scalars
from .pd import gain_matrix


class PID(LeafSystem):
    r"""Torque :math:`\tau = K_P e + K_I \int e\,dt + K_D \dot e`  (Friedlaender 2015, eq. 4.32).

    | port | size | unit |
    |---|---|---|
    | in  `error`      | n | rad |
    | in  `error_rate` | n | rad/s, from a ``FilteredDerivative`` |
    | out `torque`     | n | N m |

    One discrete state per element, the integral of the error up to the last sample (forward
    rectangles), updated every ``period`` seconds; no anti-windup. Numeric parameters ``KP`` [N m/rad],
    ``KI`` [N m/(rad s)] and ``KD`` [N m s/rad], (n, n); a number stands for that multiple of the unit
    matrix. Raises ValueError if ``period`` is not positive.
    """

    KP, KI, KD = range(3)

    def __init__(
        self, size: int, *, kp: ArrayLike, ki: ArrayLike, kd: ArrayLike, period: float
    ) -> None:
        LeafSystem.__init__(self)
        self.size = size
        self.period = scalars.positive(self, "period", period, "s")
        for gain in (kp, ki, kd):
            scalars.declare_parameter(self, gain_matrix(gain, size))
        self.DeclareDiscreteState(np.zeros(size))
        self.DeclareVectorInputPort("error", size)
        self.DeclareVectorInputPort("error_rate", size)
        self.DeclareVectorOutputPort("torque", size, self._torque)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._integrate)

    def _torque(self, context: Any, output: Any) -> None:
        n = self.size
        kp, ki, kd = (scalars.parameter(context, gain, n, n) for gain in range(3))
        error = scalars.signal(self, context, "error")
        slope = scalars.signal(self, context, "error_rate")
        integral = context.get_discrete_state_vector().value()
        output.SetFromVector([control.pid(i, kp, ki, kd, error, integral, slope) for i in range(n)])

    def _integrate(self, context: Any, discrete_state: Any) -> None:
        integral = context.get_discrete_state_vector().value()
        discrete_state.set_value(integral + self.period * scalars.signal(self, context, "error"))
