"""An arm of position servos behind the rig, with the joints of the SO-101: ``system.kind: serial_arm``.

Every joint is a servo of its own that follows its reference; the rig's controller only sends references. It homes where
it stands, brought there by hand.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...models import position_servo
from ...models.position_servo import PositionServo, ideal_servo
from ..errors import InputError
from ..gap.machines.serial_arm import INERTIA, SO101, TIME_CONSTANT
from ..gap.machines.settings import Settings
from . import faults
from .encoders import Encoders
from .machine import Axis, Floats, Layout, Trajectory
from .setpoints import out_and_back

JOINTS = ("rotation", "pitch", "elbow", "wrist_pitch")
DT, SUBSTEPS = 0.02, 20
LSB = 2.0 * np.pi / 4096  # [rad]
STIFFNESS = 17.8  # of a servo [N m/rad]
REACH = 1.2  # of a joint from the mark [rad]
MOTIONS = {
    "together": np.array([0.8, 0.8, -0.8, 0.8]),
    "fold": np.array([0.3, -0.9, 1.0, -0.6]),
    "wave": np.array([-0.8, 0.4, 0.5, -0.9]),
}


class Plant:
    """What effects act on: servos, and the weight of the links beyond each joint."""

    def __init__(self) -> None:
        self.servos = [ideal_servo(TIME_CONSTANT, INERTIA, 0.0) for _ in JOINTS]
        self.weights = np.zeros(len(SO101))  # torque of each link, level, over the stiffness [rad]

    def load(self, q: Floats) -> Floats:
        """Load (joints,) [rad] at angles q (joints,): each link weighs on every joint before it."""
        each = self.weights * np.cos(np.cumsum(q[1:]))
        return np.concatenate([[0.0], -np.cumsum(each[::-1])[::-1]])

    def change(self, **fields: float) -> None:
        """Replace constants of every servo."""
        self.servos = [servo._replace(**fields) for servo in self.servos]


class Arm:
    """The arm with a fault."""

    programs: Sequence[str] = tuple(MOTIONS)

    def __init__(self, fault: str = "none", seed: int = 0) -> None:
        self._nominal = {"time_constant_s": TIME_CONSTANT, "inertia_s2": INERTIA, "delay_s": DT}
        self._plant = Plant()
        self.answer = faults.give(fault, self._plant, FAULTS, seed)
        self.layout = _layout()
        self._encoders = Encoders(len(JOINTS), LSB)
        self._q = np.zeros(len(JOINTS))
        self.wake()

    def power_up(self, rng: np.random.Generator) -> None:
        """Stand near the mark, the encoders at zero."""
        self._q = rng.uniform(-0.02, 0.02, len(JOINTS))
        self.preset(np.zeros(len(JOINTS)))
        self.wake()

    def read(self) -> Floats:
        """Encoder readings (joints,) [rad]."""
        return self._encoders.read(self._q)

    def preset(self, motors: Floats) -> None:
        """Let the encoders read ``motors`` here."""
        self._encoders.preset(self._q, motors)

    def true_axes(self) -> Floats:
        """Where the joints really are (joints,)."""
        return self._q.copy()

    def wake(self) -> None:
        """The servos hold where they are."""
        self._rate = np.zeros(len(JOINTS))
        self._asked = self._q.copy()
        self._late = self._asked.copy()

    def step(self, reference: Floats, acceleration: Floats) -> Floats:
        """Send a reference, which the servos take up evenly over the sample; their torques' magnitudes (joints,)."""
        wanted = self._encoders.true(reference)
        h = DT / SUBSTEPS
        torque = STIFFNESS * np.abs(self._late - self._q)
        for i in range(SUBSTEPS):
            asked = self._asked + (i + 1.0) / SUBSTEPS * (wanted - self._asked)
            load = self._plant.load(self._q)
            for j, servo in enumerate(self._plant.servos):
                self._late[j] += _follows(servo, h) * (asked[j] - self._late[j])
                self._rate[j] = position_servo.next_rate(
                    self._late[j] - self._q[j], self._rate[j], load[j], servo, h
                )
            self._q = self._q + h * self._rate
        self._asked = wanted
        return torque

    def brake(self) -> None:
        """Stand still without power."""
        self.wake()

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {"controller": {"kind": "servo_position"}, "nominal": dict(self._nominal)}

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Another nominal model; the loops are inside the servos."""
        if controller.get("kind", "servo_position") != "servo_position" or len(controller) > 1:
            raise InputError("configure, controller", f"{dict(controller)}", "kind: servo_position")
        new = {**self._nominal, **nominal}
        values = Settings("configure, nominal", new, set(self._nominal))
        for key in new:
            values.number(key, positive=True)
        self._nominal = new

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """A motion of all joints out and back."""
        return out_and_back(name, MOTIONS, rate, cycles, DT)

    def columns(self) -> dict[str, str]:
        """As in every log set of an arm of position servos."""
        places = {f"{j}{end}": "rad" for end in ("_ref", "") for j in JOINTS}
        return {"t": "s", **places, **{f"{j}_abs_torque": "N m" for j in JOINTS}}

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time, references, readings, magnitudes of the torques."""
        return [time, *reference, *reading, *command]

    def document(self) -> dict[str, Any]:
        """System and controller."""
        return {
            "system": {
                "kind": "serial_arm",
                "joints": list(JOINTS),
                "parallel_axes": list(SO101),
                "nominal": dict(self._nominal),
            },
            "sample_time_s": DT,
            "controller": {"kind": "servo_position"},
        }


def _follows(servo: PositionServo, h: float) -> float:
    """Share of the way to the reference that a servo takes up in a step."""
    return 1.0 - float(np.exp(-h / servo.lag)) if servo.lag > 0.0 else 1.0


def _weight(plant: Plant, size: float) -> None:
    plant.weights = size * np.array([1.0, 0.7, 0.3])


def _friction(plant: Plant, level: float) -> None:
    plant.change(level=level)


def _lag(plant: Plant, lag: float) -> None:
    plant.change(lag=lag)


FAULTS = {
    fault.name: fault
    for fault in (
        faults.Fault(name="weight", effect="load.bias", apply=_weight,
                     strength=(0.02, 0.05), unit="rad of sag, of the first link"),
        faults.Fault(name="friction", effect="friction.coulomb", apply=_friction,
                     strength=(0.01, 0.03), unit="rad of error"),
        faults.Fault(name="lag", effect="actuator.lag", apply=_lag,
                     strength=(0.05, 0.1), unit="s"),
    )
}  # fmt: skip


def _layout() -> Layout:
    return Layout(
        kind="serial_arm",
        motors=JOINTS,
        unit="rad",
        effort="N m",
        axes=tuple(
            Axis(name=name, unit="rad", speed=0.8, acceleration=3.0, low=-REACH, high=REACH)
            for name in JOINTS
        ),
        axis_map=np.eye(len(JOINTS)),
        origin=np.zeros(len(JOINTS)),
        home=np.zeros(len(JOINTS)),
        finds_switch=False,
        lsb=LSB,
        following_error=0.6,
        dt=DT,
    )
