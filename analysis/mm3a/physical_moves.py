"""Moves by the physical stick-slip actuators, with physical causes of every effect.

Nothing here is shared with the hypotheses of the instrument: steps are those of ``models/stick_slip.py``,
every one played from the state the one before has left; loads and inertias are those of a Drake
MultibodyPlant. Day and direction act on the drive, warming on the stack's transduction, recoil is a frame
in series with the stack, a payload is a body on the tip.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import SpatialInertia, UnitInertia

from ...models import stick_slip
from ...models.mm3a.actuators import JointActuator, joint_actuators
from ...models.mm3a.arm import Arm
from ...systems.mm3a.plant import add_arm
from .moves import Series

Actuators = tuple[JointActuator, JointActuator, JointActuator]
FACTORY_STEPS = 12  # steps in positive direction that a session begins with


@dataclass(frozen=True, kw_only=True)
class Truth:
    """What is physically different from the arm that was calibrated."""

    payload: float = 0.0  # mass on the tip [kg]
    frame: float = (
        0.0  # stiffness of the stack over that of the frame along its softest direction [-]
    )
    flyback: float = 0.0  # relative difference of the flyback time, half of it each way [-]
    strength: dict[str, float] = field(default_factory=dict)  # by session, of the stack less 1 [-]
    warming: float = 0.0  # growth of the stack's strength from cold to warm [-]
    warm_up: float = 600.0  # time to 63 % of it [s]
    ripple: float = 0.0  # of the friction along the travel [-]
    period: float = 1.0  # of the ripple, in units of the joint [rad or mm]
    hysteresis: str = "bouc_wen"
    spoil: Callable[[float], float] = lambda t: 1.0


class PhysicalMover:
    """Plays every step by its actuator, from the state that the last step of the joint has left."""

    def __init__(self, truth: Truth) -> None:
        self._truth, self._parts = truth, joint_actuators()
        self._plant = cache(self._tilted)

    def begin(self, session: str) -> None:
        """Everything at rest; a few steps take the mark of the factory out of stack and contact."""
        self._session = session
        self._state = [np.zeros(stick_slip.STATES) for _ in range(3)]
        for joint in range(3):
            q = np.array([0.0, -0.5 * np.pi, 0.006])
            self._play(joint, q, -0.5 * np.pi if joint else 0.0, FACTORY_STEPS, 0.0)

    def move(self, series: Series, q: NDArray[np.float64], steps: int, t: float) -> float:
        """Displacement of the logged steps, after the run-in."""
        joint, direction = series.joint - 1, 1 if steps > 0 else -1
        if series.run_in:
            self._play(joint, q, series.theta, direction * series.run_in, t)
        return self._play(joint, q, series.theta, steps, t) * self._truth.spoil(t)

    def load_and_inertia(
        self, joint: int, q: NDArray[np.float64], theta: float
    ) -> tuple[float, float]:
        """Static load [N m or N], positive against positive motion, and inertia [kg m^2 or kg]."""
        plant, context = self._plant(float(theta))
        plant.SetPositions(context, q)
        load = -plant.CalcGravityGeneralizedForces(context)[joint]
        return float(load), float(plant.CalcMassMatrix(context)[joint, joint])

    def _play(
        self, joint: int, q: NDArray[np.float64], theta: float, steps: int, t: float
    ) -> float:
        part, direction = self._parts[joint], 1 if steps > 0 else -1
        load, inertia = self.load_and_inertia(joint, q, theta)
        drive = replace(
            part.drive, flyback=part.drive.flyback * (1.0 + 0.5 * direction * self._truth.flyback)
        )
        response = stick_slip.simulate(
            self._actuator(joint, q, t),
            drive,
            steps=abs(steps),
            direction=direction,
            load=load / part.radius,
            slider_mass=inertia / part.radius**2,
            initial=self._state[joint],
        )
        self._state[joint] = response.final
        return float(response.steps.sum()) / part.radius

    def _actuator(self, joint: int, q: NDArray[np.float64], t: float) -> stick_slip.Actuator:
        truth, actuator = self._truth, self._parts[joint].actuator
        strength = 1.0 + truth.strength.get(self._session, 0.0)
        strength *= 1.0 + truth.warming * (1.0 - np.exp(-t / truth.warm_up))
        if joint == 2:
            strength /= 1.0 + truth.frame * np.cos(q[1]) ** 2
        along = q[joint] * (1e3 if joint == 2 else 1.0)
        rubbing = 1.0 + truth.ripple * np.sin(2.0 * np.pi * along / truth.period + 1.0)
        return replace(
            actuator,
            transduction=actuator.transduction * strength,
            coulomb=actuator.coulomb * rubbing,
            hysteresis=truth.hysteresis,
        )

    def _tilted(self, theta: float) -> tuple[MultibodyPlant, Any]:
        plant = MultibodyPlant(0.0)
        add_arm(plant, Arm(), theta, 0.0)
        if self._truth.payload:
            ball = SpatialInertia(self._truth.payload, np.zeros(3), UnitInertia.SolidSphere(1e-3))
            body = plant.AddRigidBody("payload", plant.AddModelInstance("payload"), ball)
            plant.WeldFrames(plant.GetFrameByName("link_3"), body.body_frame())
        plant.Finalize()
        return plant, plant.CreateDefaultContext()
