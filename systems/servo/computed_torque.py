"""Computed torque of a parallel machine, in the joints or in the workspace."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ...models.parallel.machine import ParallelMachine
from ...models.servo_axis import ServoAxis
from .. import scalars


class ComputedTorqueLoop(LeafSystem):
    r"""Currents :math:`i = (i_R f + \tau_f)/K_t` with :math:`f = (I + J_t/i_R^2) u + C + G` (Roldan, Figs. 3.16-3.18).

    In the joints :math:`u = \ddot q_0 + k_p e + k_v \dot e`; in the workspace
    :math:`u = J^{-1}(\ddot x_0 + k_p e_x + k_v \dot e_x - \dot J\dot q)`. The machine and axis given here are what the
    controller *believes*. Friction is compensated at the joints' rate wanted: Roldan's scheme has no such term, and
    Table 4.1's Coulomb torque alone would leave a large error.

    | port | size | unit |
    |---|---|---|
    | in  `reference`, `reference_rate`, `reference_acceleration` | n | joints or task coordinates |
    | in  `joint_position` | n | rad or m |
    | in  `joint_rate`     | n | rad/s or m/s |
    | out `current`        | n | A |

    Discrete state: currents, held for ``period`` seconds. Raises ValueError if it is not positive.
    """

    def __init__(
        self,
        machine: ParallelMachine,
        axis: ServoAxis,
        *,
        period: float,
        kp: float,
        kv: float,
        workspace: bool,
        compensate_friction: bool = True,
    ) -> None:
        LeafSystem.__init__(self)
        self.machine, self.axis, self.workspace = machine, axis, workspace
        self.kp, self.kv, self.compensate = kp, kv, compensate_friction
        n = len(machine.joints)
        self.inputs = (
            "reference",
            "reference_rate",
            "reference_acceleration",
            "joint_position",
            "joint_rate",
        )
        for name in self.inputs:
            self.DeclareVectorInputPort(name, n)
        self.DeclareDiscreteState(np.zeros(n))
        self.DeclareVectorOutputPort(
            "current", n, self._held, prerequisites_of_calc={self.xd_ticket()}
        )
        self.DeclarePeriodicDiscreteUpdateEvent(
            scalars.positive(self, "period", period, "s"), 0.0, self._update
        )

    def _held(self, context: Any, output: Any) -> None:
        output.SetFromVector(context.get_discrete_state_vector().value())

    def _update(self, context: Any, discrete_state: Any) -> None:
        reference, rate, acceleration, q, v = (
            scalars.signal(self, context, name) for name in self.inputs
        )
        if self.workspace:
            jacobian, drift = self.machine.task_motion(q, v)
            at, speed = self.machine.forward(q), jacobian @ v
            wanted = acceleration + self.kp * (reference - at) + self.kv * (rate - speed)
            servo = np.linalg.solve(jacobian, wanted - drift)
            joint_rate = np.linalg.solve(jacobian, rate)
        else:
            servo = acceleration + self.kp * (reference - q) + self.kv * (rate - v)
            joint_rate = rate
        axis = self.axis
        force = self.machine.equations(q, v).force(servo) + axis.joint_inertia * servo
        torque = axis.per_motor * force
        if self.compensate:
            torque = torque + axis.friction(joint_rate / axis.per_motor)
        discrete_state.set_value(torque / axis.torque_constant)
