"""Inner loops of a cascade: velocity and current."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ...models import cascade, control
from .. import scalars


class PILoop(LeafSystem):
    r"""Sampled :math:`u = \mathrm{clip}(u_0 + k_P e + k_I \int e)`, e = command - measured (Roldan, Fig. 3.13).

    | port | size | unit |
    |---|---|---|
    | in  `command`  | n | motor rate [rad/s], or current [A] |
    | in  `measured` | n | as `command` |
    | in  `feedforward` | n | u_0, as `output`; zero if not connected |
    | out `output`   | n | current [A], or voltage [V] |

    Discrete state every ``period`` seconds: outputs held, integrals of the error (they wait while the clip holds
    the output back), and measured signals after a first-order low-pass of ``filter_time`` [s], 0 for none.
    Raises ValueError if period or limit is not positive or the rest negative.
    """

    def __init__(
        self,
        size: int,
        *,
        period: float,
        kp: float,
        ki: float,
        limit: float = np.inf,
        filter_time: float = 0.0,
    ) -> None:
        LeafSystem.__init__(self)
        if min(kp, ki, filter_time) < 0.0 or not limit > 0.0:
            raise ValueError(
                f"PILoop: kp {kp}, ki {ki}, filter_time {filter_time}, limit {limit}; expected a "
                "limit above 0 and the rest at least 0"
            )
        self.size, self.period = size, scalars.positive(self, "period", period, "s")
        self.kp, self.ki, self.limit = kp, ki, limit
        self.decay = control.derivative_decay(1.0 / filter_time, period) if filter_time else 0.0
        for name in ("command", "measured", "feedforward"):
            self.DeclareVectorInputPort(name, size)
        self.DeclareDiscreteState(np.zeros(3 * size))
        self.DeclareVectorOutputPort(
            "output", size, self._held, prerequisites_of_calc={self.xd_ticket()}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _held(self, context: Any, output: Any) -> None:
        output.SetFromVector(context.get_discrete_state_vector().value()[: self.size])

    def _update(self, context: Any, discrete_state: Any) -> None:
        _, integral, filtered = context.get_discrete_state_vector().value().reshape(3, self.size)
        measured = scalars.signal(self, context, "measured")
        seen = control.low_pass(measured, filtered, self.decay)
        error = scalars.signal(self, context, "command") - seen
        port = self.GetInputPort("feedforward")
        forward = port.Eval(context) if port.HasValue(context) else np.zeros(self.size)
        pairs = [
            cascade.proportional_integral(e, s, self.kp, self.ki, self.limit, self.period, f)
            for e, s, f in zip(error, integral, forward)
        ]
        outputs, integrals = zip(*pairs)
        discrete_state.set_value(np.concatenate([outputs, integrals, seen]))
