"""A sampled drive from the command of its controller to what its encoders read, in one system."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models import drive as drive_law
from ..models import encoder, leaf_kernels
from ..models.drive import Drive
from . import scalars


class EncodedDrive(LeafSystem):
    r"""Actuators, drive and encoders, moved on by a sample at once: the step of ``drive_kernels.simulate``.

    .. math:: \tau = \mathrm{actuator}(u), \quad M \ddot q + E^T f(E \dot q) + h(q) = \tau, \quad
       y = \mathrm{lsb} \lfloor q / \mathrm{lsb} + \tfrac12 \rfloor

    It stands for ``TorqueAmplifier``, ``SampledDrivePlant`` and ``Encoder`` in a row, with one call of
    compiled code a sample in place of seven; what it gives is the same.

    | port | size | unit |
    |---|---|---|
    | in  `command`  | motors | N m or N, held over the sample |
    | out `measured` | motors | rad or m, what the encoders read |
    | out `state`    | 2 shafts + elements + 2 motors | positions, velocities, bristle deflections, both stages of the lags |

    Two discrete states every ``period`` seconds, ``MEASURED`` and ``STATE``, as their ports. The constants belong to
    the system, not to its Context: fetching them from there takes a twelfth of a simulated sample. Where they are to be
    parameters use the three systems named above. ``set_position`` puts the drive at rest elsewhere. Raises ValueError
    if ``period`` or ``substeps`` is not positive, the count is negative, or an actuator is late: only
    ``TorqueAmplifier`` delays.
    """

    MEASURED, STATE = range(2)

    def __init__(
        self,
        drive: Drive,
        period: float,
        lsb: float,
        *,
        motors: int | None = None,
        substeps: int = 1,
    ) -> None:
        LeafSystem.__init__(self)
        self.period = scalars.positive(self, "period", period, "s")
        _check(drive, lsb, substeps)
        self.shafts = drive.shaft.shape[0]
        self.motors = self.shafts if motors is None else motors
        self._lsb = lsb
        self._constants = leaf_kernels.encoded(drive, period, substeps, lsb)
        self._fades = bool(
            np.any(drive.element[:, drive_law.FADE])
        )  # else the time does not matter
        self._command: Any = self.DeclareVectorInputPort("command", self.motors)
        size = 2 * self.shafts + len(drive.element) + 2 * self.motors
        for name, values in (("measured", self.motors), ("state", size)):
            self.DeclareStateOutputPort(name, self.DeclareDiscreteState(values))
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._advance)

    def set_position(self, context: Any, position: Any) -> None:
        """Put the shafts at ``position`` (shafts,) [rad or m], at rest; the encoders read it."""
        state = np.zeros(context.get_discrete_state(self.STATE).size())
        state[: self.shafts] = position
        context.SetDiscreteState(self.STATE, state)
        read = [encoder.read(angle, self._lsb) for angle in state[: self.motors]]
        context.SetDiscreteState(self.MEASURED, read)

    def _advance(self, context: Any, discrete_state: Any) -> None:
        # Drake hands over the states as they are before the update.
        leaf_kernels.advance_encoded(
            self._command.Eval(context),
            context.get_time() if self._fades else 0.0,
            self.shafts,
            self._constants,
            discrete_state.get_mutable_value(1),
            discrete_state.get_mutable_value(0),
        )


def _check(drive: Drive, lsb: float, substeps: int) -> None:
    if substeps < 1:
        raise ValueError(f"EncodedDrive: substeps is {substeps}; expected 1 or more")
    if not 0.0 <= lsb < np.inf:
        raise ValueError(f"EncodedDrive: lsb is {lsb}; expected a count of zero or more [rad or m]")
    delays = drive.shaft[:, drive_law.DELAY]
    if np.any(delays != 0.0):
        raise ValueError(
            f"EncodedDrive: delays are {delays.tolist()}; expected none [s]. Use TorqueAmplifier and SampledDrivePlant"
        )
