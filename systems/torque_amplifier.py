"""From torque command to the torque that reaches the shafts."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models import drive as drive_law
from ..models import leaf_kernels
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
        self._states = (2 + self.past) * self.size + 1
        self.DeclareDiscreteState(self._states)
        self.DeclareVectorInputPort("command", self.size)
        self.DeclareVectorOutputPort("torque", self.size, self._torque)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._advance)

    def _torque(self, context: Any, output: Any) -> None:
        self._deliver(context, output.get_mutable_value(), np.empty(self._states))

    def _advance(self, context: Any, discrete_state: Any) -> None:
        self._deliver(context, np.empty(self.size), discrete_state.get_mutable_value())

    def _deliver(self, context: Any, torque: Any, after: Any) -> None:
        """Write the torque (n,) of the sample that begins, and the state at its end."""
        leaf_kernels.deliver(
            scalars.constants(context, self.ACTUATOR),
            context.get_discrete_state_vector().value(),
            scalars.numbered(self, context, 0),
            self.period,
            torque,
            after,
        )
