"""Servo axes that a machine loads, and the same axes as one plant with the machine."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import BasicVector, LeafSystem

from ...models.parallel.machine import ParallelMachine
from ...models.servo_axis import ServoAxis
from .. import scalars


class ServoAxes(LeafSystem):
    r"""Equal axes, each :math:`J_t\ddot\theta = K_t i - \tau_f(\dot\theta) - i_R f`, (4.9) of Roldan.

    | port | size | unit |
    |---|---|---|
    | in  `current`      | n | A |
    | in  `load`         | n | N m or N, of the machine on the joint, against positive motion |
    | out `position`     | n | rad or m, of the joint |
    | out `rate`         | n | rad/s or m/s, of the joint |
    | out `acceleration` | n | rad/s^2 or m/s^2, of the joint |

    Continuous state: joint positions and rates. ``acceleration`` depends on both inputs at once.
    """

    def __init__(self, axis: ServoAxis, start: ArrayLike) -> None:
        LeafSystem.__init__(self)
        self.axis = axis
        self.size = n = np.size(start)
        _declare(self, np.asarray(start, dtype=float), ("current", "load"))
        self.DeclareVectorOutputPort("acceleration", n, self._write)

    def _acceleration(self, context: Any) -> Any:
        v = context.get_continuous_state_vector().CopyToVector()[self.size :]
        current = scalars.signal(self, context, "current")
        load = scalars.signal(self, context, "load")
        per = self.axis.per_motor
        return per * self.axis.motor_acceleration(v / per, current, load)

    def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
        """Write rates and accelerations of the joints."""
        _differentiate(self, context, derivatives)

    def _write(self, context: Any, output: Any) -> None:
        output.SetFromVector(self._acceleration(context))


class CoupledAxes(LeafSystem):
    r"""Axes and machine as one plant: :math:`(I(q) + J_t/i_R^2)\ddot q = (K_t i - \tau_f)/i_R - C - G`.

    | port | size | unit |
    |---|---|---|
    | in  `current`      | n | A |
    | out `position`     | n | rad or m, of the joint |
    | out `rate`         | n | rad/s or m/s, of the joint |
    | out `acceleration` | n | rad/s^2 or m/s^2, of the joint |

    Continuous state: joint positions and rates. What ``ServoAxes`` with ``MachineLoad`` tends to as the
    load's delay goes to zero.
    """

    def __init__(self, axis: ServoAxis, machine: ParallelMachine, start: ArrayLike) -> None:
        LeafSystem.__init__(self)
        self.axis, self.machine = axis, machine
        self.size = n = np.size(start)
        _declare(self, np.asarray(start, dtype=float), ("current",))
        self.DeclareVectorOutputPort("acceleration", n, self._write)

    def _acceleration(self, context: Any) -> Any:
        state = context.get_continuous_state_vector().CopyToVector()
        q, v = state[: self.size], state[self.size :]
        per = self.axis.per_motor
        at = self.machine.equations(q, v)
        force = self.axis.net_torque(v / per, scalars.signal(self, context, "current")) / per
        inertia = at.inertia + self.axis.joint_inertia * np.eye(self.size)
        return at._replace(inertia=inertia).acceleration(force)

    def DoCalcTimeDerivatives(self, context: Any, derivatives: Any) -> None:
        """Write rates and accelerations of the joints."""
        _differentiate(self, context, derivatives)

    def _write(self, context: Any, output: Any) -> None:
        output.SetFromVector(self._acceleration(context))


def _declare(system: Any, start: Any, inputs: tuple[str, ...]) -> None:
    """Ports and state that both plants share."""
    n = system.size
    for name in inputs:
        system.DeclareVectorInputPort(name, n)
    system.DeclareContinuousState(BasicVector(np.concatenate([start, np.zeros(n)])), n, n, 0)
    for name, part in (("position", slice(0, n)), ("rate", slice(n, 2 * n))):
        system.DeclareVectorOutputPort(
            name, n, _part(part), prerequisites_of_calc={system.xc_ticket()}
        )


def _part(part: slice) -> Any:
    def calc(context: Any, output: Any) -> None:
        output.SetFromVector(context.get_continuous_state_vector().CopyToVector()[part])

    return calc


def _differentiate(system: Any, context: Any, derivatives: Any) -> None:
    v = context.get_continuous_state_vector().CopyToVector()[system.size :]
    derivatives.get_mutable_vector().SetFromVector(
        np.concatenate([v, system._acceleration(context)])
    )
