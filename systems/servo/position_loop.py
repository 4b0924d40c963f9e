"""Outer loop of a cascade, in the joints or in the workspace."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ...models import cascade, control
from ...models.parallel.machine import ParallelMachine
from .. import scalars


class PositionLoop(LeafSystem):
    r"""Motor rates :math:`\dot\theta_0 = F(s)\,(k_v e + f\dot q_0)/i_R`, sampled (Roldan, Figs. 3.13-3.15).

    In the joints e = q_0 - q. With a ``machine`` the loop works in its task coordinates, e = x_0 - x, and the
    rates it asks for pass through :math:`J^{-1}(q)` to the joints (Fig. 3.14).

    | port | size | unit |
    |---|---|---|
    | in  `reference`      | n | joints [rad or m], or task coordinates |
    | in  `reference_rate` | n | the same per s |
    | in  `joint_position` | n | rad or m; in the workspace x is its forward kinematics |
    | out `motor_rate`     | n | rad/s |

    Discrete state every ``period`` seconds: the filtered rates, held. ``filter_time`` [s] of the first-order
    low-pass F, 0 for none. Raises ValueError unless the period is positive and the rest not negative.
    """

    def __init__(
        self,
        size: int,
        *,
        period: float,
        gain: float,
        per_motor: float,
        feedforward: float = 0.0,
        filter_time: float = 0.0,
        machine: ParallelMachine | None = None,
    ) -> None:
        LeafSystem.__init__(self)
        if min(gain, feedforward, filter_time) < 0.0:
            raise ValueError(
                f"PositionLoop: gain {gain}, feedforward {feedforward}, filter_time {filter_time}; "
                "expected values of at least 0"
            )
        self.gain, self.feedforward, self.per_motor = gain, feedforward, per_motor
        self.decay = control.derivative_decay(1.0 / filter_time, period) if filter_time else 0.0
        self.machine = machine
        for name in ("reference", "reference_rate", "joint_position"):
            self.DeclareVectorInputPort(name, size)
        self.DeclareDiscreteState(np.zeros(size))
        self.DeclareVectorOutputPort(
            "motor_rate", size, self._held, prerequisites_of_calc={self.xd_ticket()}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            scalars.positive(self, "period", period, "s"), 0.0, self._update
        )

    def _held(self, context: Any, output: Any) -> None:
        output.SetFromVector(context.get_discrete_state_vector().value())

    def _update(self, context: Any, discrete_state: Any) -> None:
        reference, rate, q = (
            scalars.signal(self, context, name)
            for name in ("reference", "reference_rate", "joint_position")
        )
        at = q if self.machine is None else self.machine.forward(q)
        wanted = cascade.rate_command(
            reference, at, rate, self.gain, self.feedforward, self.per_motor
        )
        if self.machine is not None:
            jacobian, _ = self.machine.task_motion(q, np.zeros_like(q))
            wanted = np.linalg.solve(jacobian, wanted)
        before = context.get_discrete_state_vector().value()
        discrete_state.set_value(control.low_pass(wanted, before, self.decay))
