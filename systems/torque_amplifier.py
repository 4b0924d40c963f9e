"""From torque command to the torque that reaches the shafts."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models import drive as drive_law
from ..models.drive import Drive
from . import scalars


class TorqueAmplifier(LeafSystem):
    r"""Actuator of each shaft: delay, gain, limit and lag, in this order.

    .. math:: (1 + \tfrac{T}{k} \tfrac{d}{dt})^k\, \tau = \mathrm{clip}(g\, u(t - d), \pm\tau_{max})

    for commands u held over a sample and k = 1 or 2 stages; the output is the mean of :math:`\tau` over the sample that
    begins. The ideal amplifier has g = 1, d = T = 0 and no limit.

    | port | size | unit |
    |---|---|---|
    | in  `command` | n | N m or N |
    | out `torque`  | n | N m or N, mean over the sample |

    Discrete state every ``period`` seconds: torques of the lag's stages (2n), whether commands have begun, and
    the past commands a delay needs (before the first sample the command is the first). Numeric
    parameter ``ACTUATOR`` (n, 5): delay [s], gain [-], limit [N m or N], lag [s], stages, the last columns
    of ``Drive.shaft``; a Context can lower the delay of the constructor, not raise it by a sample.
    Raises ValueError if ``period`` is not positive or a delay negative.
    """

    ACTUATOR = 0

    def __init__(self, drive: Drive, period: float) -> None:
        LeafSystem.__init__(self)
        self.period = scalars.positive(self, "period", period, "s")
        actuator = np.asarray(drive.shaft)[:, drive_law.DELAY :]
        if not np.all(actuator[:, 0] >= 0.0):
            raise ValueError(
                f"TorqueAmplifier: delays are {actuator[:, 0].tolist()}; expected zero or more [s]"
            )
        self.size = len(actuator)
        self.past = int(np.ceil(actuator[:, 0].max() / period)) + 1
        scalars.declare_parameter(self, actuator)
        self.DeclareDiscreteState((2 + self.past) * self.size + 1)
        self.DeclareVectorInputPort("command", self.size)
        self.DeclareVectorOutputPort("torque", self.size, self._torque)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._advance)

    def _torque(self, context: Any, output: Any) -> None:
        _, delivered, _ = self._deliver(context)
        output.SetFromVector(delivered)

    def _advance(self, context: Any, discrete_state: Any) -> None:
        commands, _, lagged = self._deliver(context)
        discrete_state.set_value(np.concatenate([*lagged, [1.0], commands[1:].ravel()]))

    def _deliver(self, context: Any) -> tuple[Any, list[float], Any]:
        """Commands (past + 1, n) up to now, delivered torque, next torques (2, n) of the lag."""
        n = self.size
        state = context.get_discrete_state_vector().value()
        command = scalars.signal(self, context, "command")
        began, past = state[2 * n] > 0.0, state[2 * n + 1 :].reshape(self.past, n)
        commands = np.vstack([past if began else np.tile(command, (self.past, 1)), command])
        delivered, lagged = [], np.zeros((2, n))
        for j, (delay, gain, limit, lag, stages) in enumerate(
            scalars.parameter(context, self.ACTUATOR, n, 5)
        ):
            late = drive_law.delayed_command(commands, self.past, j, delay, self.period)
            now, lagged[0, j], lagged[1, j] = drive_law.delivered_torque(
                late, state[j], state[n + j], gain, limit, lag, stages, self.period
            )
            delivered.append(now)
        return commands, delivered, lagged
