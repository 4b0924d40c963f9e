"""Minimum-order Luenberger observer of the motor rates."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models import control
from ..models.observer import DiscreteObserver
from . import scalars


class RateObserver(LeafSystem):
    r"""Motor rates from motor angles and torques  (Friedlaender 2015, eq. 4.22, ``models/observer.py``).

    .. math:: \kappa_{k+1} = \Phi \kappa_k + \Gamma_\psi \psi_k + \Gamma_\tau \tau_k, \quad
       \tilde{\dot\psi}_k = C_\kappa \kappa_k + C_\psi \psi_k

    | port | size | unit |
    |---|---|---|
    | in  `position` | n | rad |
    | in  `torque`   | n | N m, of one sample ago in Fig. 4-2 |
    | out `rate`     | n | rad/s |

    Discrete state kappa (n,), updated every ``period`` seconds, at first that of a machine at rest at
    position zero. Numeric parameters: the five (n, n) matrices of ``DiscreteObserver``, in its
    order; they must have been discretised for this ``period``. `rate` does not depend on `torque`
    within a sample. Raises ValueError if ``period`` is not positive.
    """

    TRANSITION, FROM_POSITION, FROM_TORQUE, RATE_FROM_STATE, RATE_FROM_POSITION = range(5)

    def __init__(self, observer: DiscreteObserver, period: float) -> None:
        LeafSystem.__init__(self)
        self.size = len(observer.transition)
        for matrix in observer:
            scalars.declare_parameter(self, matrix)
        self.DeclareDiscreteState(np.zeros(self.size))
        position = self.DeclareVectorInputPort("position", self.size)
        self.DeclareVectorInputPort("torque", self.size)
        self.DeclareVectorOutputPort(
            "rate",
            self.size,
            self._rate,
            prerequisites_of_calc={
                self.xd_ticket(),
                position.ticket(),
                self.all_parameters_ticket(),
            },
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            scalars.positive(self, "period", period, "s"), 0.0, self._observe
        )

    def _rate(self, context: Any, output: Any) -> None:
        _, _, _, from_state, from_position = self._matrices(context)
        state = context.get_discrete_state_vector().value()
        position = scalars.signal(self, context, "position")
        output.SetFromVector(
            [
                control.observed_rate(i, from_state, from_position, state, position)
                for i in range(self.size)
            ]
        )

    def _observe(self, context: Any, discrete_state: Any) -> None:
        transition, from_position, from_torque, _, _ = self._matrices(context)
        state = context.get_discrete_state_vector().value()
        position = scalars.signal(self, context, "position")
        torque = scalars.signal(self, context, "torque")
        discrete_state.set_value(
            [
                control.observer_next(
                    i, transition, from_position, from_torque, state, position, torque
                )
                for i in range(self.size)
            ]
        )

    def _matrices(self, context: Any) -> list[Any]:
        return [scalars.parameter(context, index, self.size, self.size) for index in range(5)]
