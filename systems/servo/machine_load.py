"""The machine as a disturbance of its actuators."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ...models.parallel.machine import ParallelMachine
from .. import scalars


class MachineLoad(LeafSystem):
    r"""Inverse dynamics of the machine, the block IDM of Roldan's Fig. 3.4: :math:`f = I\ddot q + C + G`.

    | port | size | unit |
    |---|---|---|
    | in  `position`     | n | rad or m |
    | in  `rate`         | n | rad/s or m/s |
    | in  `acceleration` | n | rad/s^2 or m/s^2 |
    | out `load`         | n | N m or N, what the joints must bear |

    Sampled: the load is computed from the motion every ``period`` seconds and held. The joints' acceleration
    depends on the load, an algebraic loop that the sample opens: the load lags by one period, and the scheme
    diverges once the machine's inertia exceeds the actuators'. Raises ValueError if ``period`` is not positive.
    """

    def __init__(self, machine: ParallelMachine, period: float) -> None:
        LeafSystem.__init__(self)
        self.machine, n = machine, len(machine.joints)
        for name in ("position", "rate", "acceleration"):
            self.DeclareVectorInputPort(name, n)
        self.DeclareDiscreteState(np.zeros(n))
        self.DeclareVectorOutputPort(
            "load", n, self._load, prerequisites_of_calc={self.xd_ticket()}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            scalars.positive(self, "period", period, "s"), 0.0, self._update
        )

    def _load(self, context: Any, output: Any) -> None:
        output.SetFromVector(context.get_discrete_state_vector().value())

    def _update(self, context: Any, discrete_state: Any) -> None:
        q, v, a = (
            scalars.signal(self, context, name) for name in ("position", "rate", "acceleration")
        )
        discrete_state.set_value(self.machine.equations(q, v).force(a))
