"""Teleoperation of the MM3A: a hand's velocity command becomes steps (Damani 2013, chapter 8)."""

from typing import Any

import numpy as np
from pydrake.systems.framework import BasicVector, EventStatus, LeafSystem

from ...models.mm3a import open_loop, stepper
from ...models.mm3a.arm import Arm
from ...models.mm3a.kinematics import within_limits
from ...models.mm3a.step_size import STEP_TIME, StepModel
from ...models.mm3a.stepper import Conditions

JOINTS = 3


class VelocityToSteps(LeafSystem):
    r"""Turns a tip velocity into at most one step per joint and tick, without any sensor.

    :math:`r \leftarrow r + s J^{-1}(\hat q)\,v\,T`; joint j steps when :math:`|r_j|` exceeds half its believed
    step, which then leaves :math:`r` and enters the believed joints :math:`\hat q`. The factor
    :math:`s \le 1` slows a command that needs more than one step per tick, without bending its direction.

    | port | size | unit |
    |---|---|---|
    | in  `velocity` | 3 | m/s of the tip, in frame 0 |
    | out `commands` | 3 | -1, 0 or 1 |
    | out `believed` | 3 | rad, rad, m: posture by dead reckoning |

    Discrete state, updated every ``STEP_TIME`` shortly before the stepper: commands, believed joints, rest
    r, last direction, steps taken. A joint at its limit takes no further step towards it, nor does any
    joint while the tip is closer than 1 mm to the axis of joint 1, where J has no inverse. Raises
    ValueError for a start outside the joint limits.
    """

    def __init__(
        self,
        start: Any,
        *,
        model: StepModel | None = None,
        arm: Arm | None = None,
        conditions: Conditions | None = None,
    ) -> None:
        super().__init__()
        self._arm = arm or Arm()
        if not within_limits(start, self._arm):
            raise ValueError(
                f"teleoperation: start {tuple(start)} is outside the joint limits "
                f"{self._arm.lower} to {self._arm.upper}"
            )
        self._table = (model or StepModel()).table()
        self._session = (conditions or Conditions()).session()
        self._velocity = self.DeclareVectorInputPort("velocity", BasicVector(JOINTS))
        zero = np.zeros(JOINTS)
        self._commands = self.DeclareDiscreteState(zero)
        self._believed = self.DeclareDiscreteState(np.array(start, dtype=float))
        self._rest = self.DeclareDiscreteState(zero)
        self._last = self.DeclareDiscreteState(zero)
        self._taken = self.DeclareDiscreteState(zero)
        self.DeclareStateOutputPort("commands", self._commands)
        self.DeclareStateOutputPort("believed", self._believed)
        self.DeclarePeriodicDiscreteUpdateEvent(STEP_TIME, 0.5 * STEP_TIME, self._update)

    def _update(self, context: Any, discrete: Any) -> EventStatus:
        q, rest, last, taken = (
            np.array(context.get_discrete_state(index).value())
            for index in (self._believed, self._rest, self._last, self._taken)
        )
        rest = rest + self._demand(np.array(self._velocity.Eval(context)), q, last, taken)
        commands = np.zeros(JOINTS)
        for joint in range(JOINTS):
            step = open_loop.next_step(
                rest[joint], joint, q, last, taken, self._table, self._session, self._arm
            )
            if step == 0:
                continue
            before = q[joint]
            blocked = stepper.coarse_step(
                joint,
                step,
                q,
                last,
                taken,
                self._table,
                self._session,
                self._arm,
                self._arm.lower,
                self._arm.upper,
            )
            if blocked:
                rest[joint] = 0.0
                q[joint] = before
            else:
                rest[joint] -= q[joint] - before
                commands[joint] = step
        for index, value in (
            (self._commands, commands),
            (self._believed, q),
            (self._rest, rest),
            (self._last, last),
            (self._taken, taken),
        ):
            discrete.set_value(index, value)
        return EventStatus.Succeeded()

    def _demand(self, velocity: Any, q: Any, last: Any, taken: Any) -> Any:
        """Joint motion wanted this tick, slowed to what one step per joint can give."""
        reach = self._arm.shoulder - (self._arm.forearm + q[2]) * np.sin(q[1])
        if abs(reach) < open_loop.AXIS_CLEARANCE:
            return np.zeros(JOINTS)
        wanted = STEP_TIME * np.array(open_loop.joint_rates(velocity, q, self._arm))
        capable = np.array(
            [
                abs(
                    stepper.coarse_motion(
                        joint,
                        1 if wanted[joint] > 0.0 else -1,
                        q,
                        last,
                        taken,
                        self._table,
                        self._session,
                        self._arm,
                    )
                )
                for joint in range(JOINTS)
            ]
        )
        return wanted / max(1.0, float(np.max(np.abs(wanted) / capable)))
