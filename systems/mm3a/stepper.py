"""The MM3A's joints as steppers: one interface, an empirical and a physical model behind it."""

from abc import abstractmethod
from typing import Any, final

import numpy as np
from numpy.typing import NDArray
from pydrake.systems.framework import BasicVector, EventStatus, LeafSystem

from ...models import stick_slip
from ...models.mm3a import dynamics, stepper
from ...models.mm3a.actuators import JointActuator, joint_actuators
from ...models.mm3a.arm import Arm, gravity_in_base
from ...models.mm3a.kinematics import within_limits
from ...models.mm3a.step_size import STEP_TIME, StepModel
from ...models.mm3a.stepper import Conditions

JOINTS = 3


class Stepper(LeafSystem):
    r"""Three stick-slip joints that take at most one step each per 10 ms: the ports both models share.

    :math:`q_j \leftarrow \mathrm{clip}(q_j + s_j\gamma_j)`, one joint after the other.

    | port | size | unit |
    |---|---|---|
    | in  `commands` | 3 | -1, 0 or 1 coarse step this tick |
    | in  `fine`     | 3 | whole fine steps this tick (optional) |
    | in  `force`    | 3 | N on the tip, in frame 0 (optional) |
    | out `joints`   | 3 | rad, rad, m: coarse position plus fine extension |
    | out `motion`   | 3 | rad, rad, m moved by the coarse steps of the last tick |
    | out `stopped`  | 3 | 1 where the last step ran against an end stop |
    | out `taken`    | 3 | coarse steps since the start |

    Discrete state, updated every ``STEP_TIME``: position, last direction, steps taken, fine extension,
    stop, motion, and the memory of the model. Gravity and the factors of the day are numeric parameters of
    the Context (``set_tilt``, ``set_scale``). The update raises ValueError for other commands.
    """

    def __init__(self, start: Any, arm: Arm | None, conditions: Conditions | None) -> None:
        super().__init__()
        self.arm = arm or Arm()
        conditions = conditions or Conditions()
        if not within_limits(start, self.arm):
            raise ValueError(
                f"stepper: start {tuple(start)} is outside the joint limits {self.arm.lower} to "
                f"{self.arm.upper}"
            )
        self._session = conditions.session()
        self._gravity = self.DeclareNumericParameter(BasicVector(self._session.gravity))
        self._scale = self.DeclareNumericParameter(BasicVector(self._session.scale.ravel()))
        self._commands = self.DeclareVectorInputPort("commands", BasicVector(JOINTS))
        self._fine = self.DeclareVectorInputPort("fine", BasicVector(JOINTS))
        self._force = self.DeclareVectorInputPort("force", BasicVector(JOINTS))
        zero = np.zeros(JOINTS)
        self._q = self.DeclareDiscreteState(np.array(start, dtype=float))
        self._last = self.DeclareDiscreteState(zero)
        self._taken = self.DeclareDiscreteState(zero)
        self._extension = self.DeclareDiscreteState(zero)
        self._stopped = self.DeclareDiscreteState(zero)
        self._motion = self.DeclareDiscreteState(zero)
        self.DeclareVectorOutputPort(
            "joints",
            JOINTS,
            self._calc_joints,
            {
                self.discrete_state_ticket(self._q),
                self.discrete_state_ticket(self._extension),
            },
        )
        self.DeclareStateOutputPort("motion", self._motion)
        self.DeclareStateOutputPort("stopped", self._stopped)
        self.DeclareStateOutputPort("taken", self._taken)
        self.DeclarePeriodicDiscreteUpdateEvent(STEP_TIME, 0.0, self._update)

    @abstractmethod
    def coarse_motion(
        self, context: Any, discrete: Any, joint: int, direction: int, q: Any, session: Any
    ) -> float:
        """Signed motion of one step [rad or m] before the end stop; may update its own memory."""

    def set_tilt(self, context: Any, theta: float, psi: float) -> None:
        """Tilt the base: R_W0 = R_x(theta) R_y(psi) [rad]."""
        context.get_mutable_numeric_parameter(self._gravity).SetFromVector(
            gravity_in_base(theta, psi)
        )

    def set_scale(self, context: Any, scale: NDArray[np.float64]) -> None:
        """Set the factors of the day, (3, 2) by joint and direction (negative, positive)."""
        if np.shape(scale) != (JOINTS, 2):
            raise ValueError(f"scale has shape {np.shape(scale)}; expected (3, 2)")
        context.get_mutable_numeric_parameter(self._scale).SetFromVector(np.ravel(scale))

    def _update(self, context: Any, discrete: Any) -> EventStatus:
        commands: Any = np.array(self._commands.Eval(context))
        if np.any(np.abs(commands) > 1) or np.any(commands != np.round(commands)):
            raise ValueError(f"stepper: commands are {commands}; expected -1, 0 or 1 per joint")
        session = self._present_session(context)
        q = np.array(context.get_discrete_state(self._q).value())
        motion, stopped = np.zeros(JOINTS), np.zeros(JOINTS)
        for joint in np.flatnonzero(commands):
            direction = int(commands[joint])
            moved = self.coarse_motion(context, discrete, int(joint), direction, q, session)
            target = q[joint] + moved
            held = min(max(target, self.arm.lower[joint]), self.arm.upper[joint])
            motion[joint], stopped[joint] = held - q[joint], float(held != target)
            q[joint] = held
        last = np.array(context.get_discrete_state(self._last).value())
        discrete.set_value(self._q, q)
        discrete.set_value(self._motion, motion)
        discrete.set_value(self._stopped, stopped)
        discrete.set_value(self._last, np.where(commands != 0, commands, last))
        taken = np.array(context.get_discrete_state(self._taken).value())
        discrete.set_value(self._taken, taken + np.abs(commands))
        discrete.set_value(self._extension, self._extended(context))
        return EventStatus.Succeeded()

    def _present_session(self, context: Any) -> stepper.Session:
        gravity = context.get_numeric_parameter(self._gravity).CopyToVector()
        scale = context.get_numeric_parameter(self._scale).CopyToVector()
        force: Any = (
            self._force.Eval(context) if self._force.HasValue(context) else np.zeros(JOINTS)
        )
        return self._session._replace(
            gravity=tuple(gravity), force=tuple(force), scale=scale.reshape(JOINTS, 2)
        )

    def _extended(self, context: Any) -> list[float]:
        extension = context.get_discrete_state(self._extension).value()
        fine: Any = self._fine.Eval(context) if self._fine.HasValue(context) else np.zeros(JOINTS)
        return [
            stepper.fine_extension(extension[joint], round(fine[joint]), joint)
            for joint in range(JOINTS)
        ]

    def _calc_joints(self, context: Any, output: Any) -> None:
        extension = context.get_discrete_state(self._extension).value()
        output.SetFromVector(context.get_discrete_state(self._q).value() + extension)


@final
class EmpiricalStepper(Stepper):
    """``Stepper`` by the empirical step sizes of chapters 4-6, law (1) of ``models/mm3a/stepper.py``.

    Ports and state of ``Stepper``; no memory beyond the last direction and the steps taken, which feed
    warming and reversal loss.
    """

    def __init__(
        self,
        start: Any,
        *,
        model: StepModel | None = None,
        arm: Arm | None = None,
        conditions: Conditions | None = None,
    ) -> None:
        super().__init__(start, arm, conditions)
        self._table = (model or StepModel()).table()

    def coarse_motion(
        self, context: Any, discrete: Any, joint: int, direction: int, q: Any, session: Any
    ) -> float:
        """Evaluate the empirical law at the posture before the step."""
        return stepper.coarse_motion(
            joint,
            direction,
            q,
            context.get_discrete_state(self._last).value(),
            context.get_discrete_state(self._taken).value(),
            self._table,
            session,
            self.arm,
        )


@final
class PhysicalStepper(Stepper):
    """``Stepper`` by the stick-slip actuators of ``models/mm3a/actuators.py``.

    Each step plays one sawtooth with load and inertia of the posture before it. The stack, bristle and
    hysteresis state of every joint is carried from step to step, which is its direction memory; a resting
    joint keeps it. Ports of ``Stepper``, 8 more discrete states per joint. Conditions give tilt,
    force and factors of the day; their warming and reversal loss belong to the empirical law and
    must be zero here, else ValueError.
    """

    def __init__(
        self,
        start: Any,
        *,
        actuators: tuple[JointActuator, JointActuator, JointActuator] | None = None,
        arm: Arm | None = None,
        conditions: Conditions | None = None,
    ) -> None:
        super().__init__(start, arm, conditions)
        if np.any(self._session.heating) or np.any(self._session.reversal_loss):
            raise ValueError(
                "physical stepper: heating and reversal_loss are terms of the empirical law; "
                "expected zero"
            )
        self._actuators = actuators or joint_actuators()
        self._memory = [
            self.DeclareDiscreteState(np.zeros(stick_slip.STATES)) for _ in range(JOINTS)
        ]

    def coarse_motion(
        self, context: Any, discrete: Any, joint: int, direction: int, q: Any, session: Any
    ) -> float:
        """Play one sawtooth from the joint's stored state."""
        part = self._actuators[joint]
        load = dynamics.static_load(q, session.gravity, session.force, self.arm)[joint]
        inertia = dynamics.mass_diagonal(q, self.arm)[joint]
        response = stick_slip.simulate(
            part.actuator,
            part.drive,
            steps=1,
            direction=direction,
            load=float(load) / part.radius,
            slider_mass=float(inertia) / part.radius**2,
            initial=context.get_discrete_state(self._memory[joint]).value(),
        )
        discrete.set_value(self._memory[joint], response.final)
        side = 1 if direction > 0 else 0
        return float(response.steps[0]) / part.radius * session.scale[joint, side]
