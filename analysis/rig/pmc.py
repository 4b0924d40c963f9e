"""The PepperMill-Carrier behind the rig: two C-drives, carriages with switches, cranks with safe limits.

It homes where it stands: by hand it is brought to the mark, the start of its cycle, and the encoders are set there,
as its own controllers assume. Counts from the mark are what a log holds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from ...models import encoder
from ...models.pmc import constants, control, limits, simulation
from ...models.pmc.controllers import ComputedTorque, JointPD, TaskSpacePD, controller
from ...models.pmc.cycle import IndustryCycle, LameCycle, Placement
from ...models.pmc.parameters import PMCParameters
from ..errors import InputError
from .faults import MYSTERY
from .machine import Axis, Floats, Layout, Trajectory

MOTORS = ("L1", "R1", "L2", "R2")
CYCLES = {"industry": IndustryCycle, "smooth": LameCycle}
SETTINGS = {"ts": TaskSpacePD, "pd": JointPD, "ct": ComputedTorque}
# Where the workspace study found the cycle to fit best.
PLACE = {"x": 0.299, "y": 0.299, "z": -0.2229, "direction": 0.75 * np.pi}
FAULTS = {"payload": (0.3, 1.0, "kg"), "friction": (0.05, 0.15, "N m")}


class Carrier:
    """The prototype with a fault, under task-space PD until it is configured otherwise."""

    programs: Sequence[str] = tuple(CYCLES)

    def __init__(self, fault: str = "none", seed: int = 0) -> None:
        self._believed = PMCParameters()
        self._machine, self.answer = _faulty(self._believed, fault, seed)
        self._kind, self._gains = "ts", asdict(TaskSpacePD())
        geometry = self._believed.geometry
        self._placement = Placement(phi=geometry.centre_angle, **PLACE)
        self._home = self._cycle("industry", 1.0, 0.0).joints[0]
        self._joint_map = constants.joint_map(self._believed.drive.lead)
        self.layout = _layout(self._believed, self._joint_map, self._home)
        self._plant = constants.of(self._machine)
        self._offset = np.zeros(4)
        self._joints, self._rates = tuple(self._home), (0.0,) * 4
        self._law = self._controller()
        self.wake()

    def power_up(self, rng: np.random.Generator) -> None:
        """Stand on the mark, where somebody has put it by hand."""
        self._joints = tuple(self._home)
        self.brake()
        self.preset(np.zeros(4))

    def _true(self) -> Floats:
        return constants.motor_map(self._believed.drive.lead) @ (
            np.array(self._joints) - self._home
        )

    def read(self) -> Floats:
        """Encoder readings (4,) [rad]."""
        return np.array([encoder.read(v, self.layout.lsb) for v in self._true() - self._offset])

    def preset(self, motors: Floats) -> None:
        """Let the encoders read ``motors`` here."""
        self._offset = self._true() - motors

    def true_axes(self) -> Floats:
        """True joints (4,)."""
        return np.array(self._joints)

    def wake(self) -> None:
        """Controller at rest at the present reading."""
        self._memory = np.zeros((5, 4))
        control.wake_up(self.read(), self._law, self._memory)

    def step(self, reference: Floats, acceleration: Floats) -> Floats:
        """Control and plant of one sample; the torques (4,)."""
        joints = self._home + self._joint_map @ reference
        torque = np.zeros(4)
        self._joints, self._rates = simulation.one_sample(
            joints, self._joint_map @ acceleration, self.read(), self._law, self._plant,
            self.layout.dt, self._memory, self._joints, self._rates, torque,
        )  # fmt: skip
        return torque

    def brake(self) -> None:
        """Stand still without power."""
        self._rates = (0.0,) * 4

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {
            "controller": {"kind": self._kind, **_lists(self._gains)},
            "nominal": _lists(asdict(self._believed)),
        }

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Another controller or gains; of the nominal model the numbers at its top."""
        before = self._kind, self._gains, self._believed
        kind = controller.get("kind", self._kind)
        if kind not in SETTINGS:
            raise InputError(
                "configure, controller.kind", f"{kind!r}", f"one of {', '.join(SETTINGS)}"
            )
        gains = self._gains if kind == self._kind else asdict(SETTINGS[kind]())
        try:
            self._kind = kind
            self._gains = {**gains, **{k: v for k, v in controller.items() if k != "kind"}}
            self._believed = replace(self._believed, **nominal)
            self._law = self._controller()
        except (TypeError, ValueError) as error:
            self._kind, self._gains, self._believed = before
            raise InputError("configure", str(error), "keys and values as they are shown") from None

    def _controller(self) -> control.Controller:
        settings = SETTINGS[self._kind](**self._gains)
        return controller(settings, self._believed, self._home, self.layout.dt)

    def _cycle(self, name: str, speed: float, cycles: float) -> simulation.Reference:
        kind = CYCLES[name]
        plain: Any = kind(placement=self._placement)
        times = ("time",) if name == "smooth" else ("lift_time", "travel_time")
        cycle = kind(
            placement=self._placement, **{key: getattr(plain, key) / speed for key in times}
        )
        return simulation.sample_cycle(cycle, self._believed, cycles=cycles)

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """A test cycle; ``rate`` is its speed, 1 is the printed one."""
        if name not in CYCLES:
            raise InputError("trajectory", f"unknown cycle {name!r}", f"one of {', '.join(CYCLES)}")
        if not 0.05 <= rate <= 3.0 or not 1 <= cycles <= 20:
            raise InputError("trajectory", f"speed {rate}, {cycles} cycles", "0.05 to 3, 1 to 20")
        reference = self._cycle(name, rate, cycles)
        to_motors = np.linalg.inv(self._joint_map).T
        return Trajectory(
            name=f"{name} x {rate:g}",
            position=(reference.joints - self._home) @ to_motors,
            acceleration=reference.joint_accelerations @ to_motors,
            keys={"motion": name, "speed": rate},
        )

    def columns(self) -> dict[str, str]:
        """As ``gapscope simulate pmc`` writes them."""
        units = {"t": "s"}
        for motor in MOTORS:
            units |= {f"psi_{motor}_ref": "rad", f"psi_{motor}": "rad", f"tau_{motor}": "N m"}
        return units

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time, then reference, reading and torque of each motor in turn."""
        return [time, *np.column_stack([reference, reading, command]).ravel().tolist()]

    def document(self) -> dict[str, Any]:
        """System and controller."""
        blocks = self.settings()
        home = [float(v) for v in self._home]
        return {
            "system": {"kind": "pmc", "nominal": blocks["nominal"], "home": home},
            "sample_time_s": self.layout.dt,
            "controller": blocks["controller"],
        }


def _faulty(nominal: PMCParameters, fault: str, seed: int) -> tuple[PMCParameters, str]:
    rng = np.random.default_rng(seed)
    name = str(rng.choice(sorted(FAULTS))) if fault == MYSTERY else fault
    if name == "none":
        return nominal, "none: the machine is its nominal model"
    if name not in FAULTS:
        raise InputError(
            "--fault", f"unknown fault {name!r}", f"one of none, {MYSTERY}, {', '.join(FAULTS)}"
        )
    low, high, unit = FAULTS[name]
    strength = float(rng.uniform(low, high))
    if name == "payload":
        return replace(nominal, payload=strength), f"inertia.payload of {strength:.3g} {unit}"
    drive = replace(nominal.drive, delta=strength)
    return replace(
        nominal, drive=drive
    ), f"friction.coulomb of {strength:.3g} {unit} on every motor"


def _layout(machine: PMCParameters, joint_map: Floats, home: Floats) -> Layout:
    g = machine.geometry
    carriages = [
        Axis(
            name=f"carriage {i}",
            unit="m",
            speed=0.1,
            acceleration=0.5,
            low=g.carriage_min - 1e-3,
            high=g.carriage_max + 1e-3,
        )
        for i in (1, 2)
    ]
    bounds = limits.theta_bounds(g)
    cranks = [
        Axis(name=f"crank {i + 1}", unit="rad", speed=0.3, acceleration=2.0, low=low, high=high)
        for i, (low, high) in enumerate(bounds)
    ]
    return Layout(
        kind="pmc",
        motors=MOTORS,
        unit="rad",
        effort="N m",
        axes=(*carriages, *cranks),
        axis_map=joint_map,
        origin=np.array(home),
        home=np.zeros(4),
        finds_switch=False,
        lsb=encoder.resolution(machine.encoder_bits) if machine.encoder_bits else 0.0,
        following_error=2.0,
    )


def _lists(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _lists(item) for key, item in value.items()}
    return list(value) if isinstance(value, tuple) else value
