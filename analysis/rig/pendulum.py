"""A pendulum on a position servo behind the rig, such as an XL330: ``system.kind: pendulum``.

The servo closes its loop itself, on an absolute encoder; the rig sends references and logs the firmware's PWM register and
the supply. While the motor is switched off somebody holds the pendulum. The firmware's gain ``kp`` is stated by run.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...models import servo_pendulum, servo_pendulum_kernels
from ...models.servo_pendulum import COUNTS_PER_TURN, GRAVITY, PWM_FULL_SCALE, ServoPendulum
from ..errors import InputError
from ..gap.machines.pendulum import RESISTANCE, ROTOR_INERTIA, TORQUE_CONSTANT, WRAP
from ..gap.machines.settings import Settings
from . import faults
from .machine import Axis, Floats, Layout, Trajectory
from .setpoints import out_and_back

DT, SUBSTEPS = 0.005, 5  # of the log [s]; the firmware's loop runs every millisecond
LSB = 2.0 * np.pi / COUNTS_PER_TURN  # of the encoder [rad]
SUPPLY = 7.4  # [V]
GAIN = 400.0  # kp of the firmware to begin with
SWINGS = {"short": 0.8, "long": 1.6, "back": -1.2}  # [rad]
NOMINAL = {
    "mass_kg": 0.49,
    "length_m": 0.1,
    "torque_constant_Nm_per_A": TORQUE_CONSTANT,
    "resistance_ohm": RESISTANCE,
    "rotor_inertia_kg_m2": ROTOR_INERTIA,
}


class Plant:
    """What effects act on."""

    def __init__(self) -> None:
        mass, length = NOMINAL["mass_kg"], NOMINAL["length_m"]
        self.servo: ServoPendulum = servo_pendulum.ideal_servo(
            mass * length**2 + NOMINAL["rotor_inertia_kg_m2"],
            mass * GRAVITY * length,
            NOMINAL["torque_constant_Nm_per_A"],
            NOMINAL["resistance_ohm"],
        )

    def change(self, **fields: float) -> None:
        """Replace constants of the servo."""
        self.servo = self.servo._replace(**fields)

    def carry(self, mass: float) -> None:
        """More mass at the end of the pendulum [kg]."""
        length = NOMINAL["length_m"]
        self.change(
            inertia=self.servo.inertia + mass * length**2,
            gravity=self.servo.gravity + mass * GRAVITY * length,
        )


class Pendulum:
    """The pendulum with a fault."""

    programs: Sequence[str] = tuple(SWINGS)

    def __init__(self, fault: str = "none", seed: int = 0) -> None:
        self._nominal: dict[str, Any] = dict(NOMINAL)
        self._controller: dict[str, Any] = {"kind": "servo_position", "kp": GAIN}
        self._plant = Plant()
        self.answer = faults.give(fault, self._plant, FAULTS, seed)
        self.layout = _layout()
        self._q = self._v = self._lag = self._seen = 0.0

    def power_up(self, rng: np.random.Generator) -> None:
        """Hang down."""
        self._q = self._v = 0.0

    def read(self) -> Floats:
        """Encoder reading (1,) [rad]."""
        return np.array([servo_pendulum.counted(self._q)])

    def preset(self, motors: Floats) -> None:
        """Nothing: the encoder is absolute."""

    def true_axes(self) -> Floats:
        """Where the pendulum really is (1,)."""
        return np.array([self._q])

    def wake(self) -> None:
        """The firmware's loop has no memory, its amplifier no voltage."""
        self._lag = 0.0

    def step(self, reference: Floats, acceleration: Floats) -> Floats:
        """Send a reference; the voltage (1,) that the firmware's law makes of it at first."""
        wanted, gain = float(reference[0]), float(self._controller["kp"])
        duty = servo_pendulum.duty(wanted - self.read()[0], gain)
        self._q, self._v, self._lag = servo_pendulum_kernels.advance(
            self._q, self._v, self._lag, wanted, SUPPLY, gain, 1.0, self._plant.servo, DT, SUBSTEPS
        )
        return np.array([SUPPLY * duty])

    def brake(self) -> None:
        """Switched off, and held."""
        self._v = 0.0

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {"controller": dict(self._controller), "nominal": dict(self._nominal)}

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Another gain of the firmware, or another nominal model."""
        new_controller = {**self._controller, **controller}
        new_nominal = {**self._nominal, **nominal}
        where = "configure, controller"
        Settings(where, new_controller, set(self._controller)).number("kp", positive=True)
        if new_controller["kind"] != "servo_position":
            raise InputError(f"{where}.kind", repr(new_controller["kind"]), "servo_position")
        values = Settings("configure, nominal", new_nominal, set(NOMINAL))
        for key in NOMINAL:
            values.number(key, positive=True)
        self._controller, self._nominal = new_controller, new_nominal

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """A swing out and back."""
        swings = {key: np.array([value]) for key, value in SWINGS.items()}
        found = out_and_back(name, swings, rate, cycles, DT)
        return Trajectory(
            name=found.name,
            position=found.position,
            acceleration=found.acceleration,
            keys={"note": found.name, "kp": self._controller["kp"]},
        )

    def columns(self) -> dict[str, str]:
        """As in every log set of a servo pendulum."""
        return {
            "t": "s",
            "q_ref": "rad",
            "q": "rad",
            "load_raw": "firmware units, wraps at 65536",
            "volts": "V",
            "torque_enable": "0/1",
        }

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time, reference, reading, PWM register, supply, motor on."""
        register = round(float(command[0]) / SUPPLY * PWM_FULL_SCALE)
        return [time, reference[0], reading[0], register % WRAP, SUPPLY, 1.0]

    def document(self) -> dict[str, Any]:
        """System and controller."""
        return {
            "system": {"kind": "pendulum", **self._nominal},
            "sample_time_s": DT,
            "controller": {"kind": "servo_position"},
        }


def _rub(plant: Plant, level: float) -> None:
    plant.change(forward=level, backward=level)


def _lose(plant: Plant, share: float) -> None:
    plant.change(motor_share=share, load_share=share)


FAULTS = {
    fault.name: fault
    for fault in (
        faults.Fault(name="friction", effect="friction.coulomb", apply=_rub,
                     strength=(0.03, 0.06), unit="N m"),
        faults.Fault(name="gear", effect="friction.load_dependent", apply=_lose,
                     strength=(0.15, 0.3), unit="of the torque that the gear carries"),
        faults.Fault(name="damping", effect="friction.viscous",
                     apply=lambda plant, value: plant.change(viscous=value),
                     strength=(0.01, 0.02), unit="N m s/rad"),
        faults.Fault(name="payload", effect="inertia.payload", apply=Plant.carry,
                     strength=(0.1, 0.2), unit="kg"),
    )
}  # fmt: skip


def _layout() -> Layout:
    return Layout(
        kind="pendulum",
        motors=("servo",),
        unit="rad",
        effort="V",
        axes=(Axis(name="pendulum", unit="rad", speed=1.5, acceleration=6.0, low=-2.2, high=2.2),),
        axis_map=np.ones((1, 1)),
        origin=np.zeros(1),
        home=np.zeros(1),
        finds_switch=False,
        lsb=LSB,
        following_error=1.0,
        dt=DT,
        rate=0.5,
    )
