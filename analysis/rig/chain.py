"""Any parallel machine of the toolbox behind the rig, on equal geared axes with PID loops at the motors.

Plant and nominal model are built by the reader of its log sets from the same ``system.nominal``; what differs is the fault.
It homes where it stands: by hand it is brought to the mark, in the middle of its travel, and the encoders are set there.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ...models.c_drive_controllers import feedback
from ...models.dc_motor import joint_per_motor
from ...models.drive import BIAS, Drive
from ...models.drive_kernels import INTEGRAL, LoopController
from ..errors import InputError
from ..gap.chain_machine import ChainMachine, ChainPlant
from ..gap.machines.parallel import AXIS_KEYS, KINDS, chain_machine
from ..gap.machines.settings import DEFAULT_TOLERANCE, Settings
from . import faults
from .drive_machine import DriveMachine
from .machine import Axis, Floats, Layout, Trajectory
from .posture import Posture
from .setpoints import out_and_back

OVERRUN = 1.2  # postures known, as a multiple of the travel to a switch
PROGRAMS = ("together", "opposed", "single")


@dataclass(frozen=True, kw_only=True)
class Chain:
    """One parallel machine on the rig: what its log set states, and where it moves."""

    kind: str  # system.kind
    nominal: Mapping[str, float]  # system.nominal
    mark: tuple[float, ...]  # joints [rad or m]
    travel: float  # of a joint from the mark to its switches [rad or m]
    speed: float  # of a jog [rad/s or m/s]
    count: float  # of the motors' encoders [rad]
    payload: tuple[float, float]  # of the fault of that name [kg]
    servo: float = 100.0  # bandwidth of the loops [rad/s]
    feed_forward: str = "none"  # "load" adds the nominal machine's pull at the reference

    @cached_property
    def per_motor(self) -> float:
        """Joint motion per motor angle."""
        lead = self.nominal.get("lead_m_per_rev")
        return joint_per_motor(self.nominal["gear_ratio"], lead)

    @cached_property
    def home(self) -> Floats:
        """The mark in whole counts."""
        step = self.per_motor * self.count
        return np.asarray(step * np.round(np.array(self.mark) / step))

    def machine(self, nominal: Mapping[str, float]) -> ChainMachine:
        """As the instrument reads it. InputError for a bad number."""
        values = Settings("configure, nominal", nominal, set(KINDS[self.kind].keys | AXIS_KEYS))
        try:
            chain = KINDS[self.kind].build(values)
        except InputError:
            raise
        except ValueError as error:
            found, _, expected = str(error).partition("; expected ")
            raise InputError("configure, nominal", found, expected) from None
        return chain_machine(self.kind, chain, values, DEFAULT_TOLERANCE)


class ChainDrive(DriveMachine):
    """The machine with a fault, under the PID it comes with until it is configured otherwise."""

    programs: Sequence[str] = PROGRAMS

    def __init__(self, chain: Chain, fault: str = "none", seed: int = 0) -> None:
        self._chain = chain
        self._nominal: dict[str, Any] = dict(chain.nominal)
        machine = chain.machine(self._nominal)
        sound = machine.build(machine.nominal())
        assert isinstance(sound, ChainPlant)
        plant, self._own = sound.drive.copy(), np.array(sound.inertia)
        self.substeps = sound.substeps
        self._weights = sound.weights.copy()
        self.answer = faults.give(fault, plant, self._faults(), seed)
        self._bias = plant.shaft[:, BIAS].copy()
        place = (chain.per_motor, chain.home, OVERRUN * chain.travel)
        self._posture = Posture(machine.chain, self._weights, *place)
        self._believed = (
            self._posture
            if np.array_equal(self._weights, sound.weights)
            else Posture(machine.chain, sound.weights, *place)
        )
        n = len(chain.mark)
        self._before = np.zeros(n)
        shaft = float(np.mean(np.diag(self._own + self._believed.at(np.zeros(n))[0])))
        self._controller: dict[str, Any] = {
            **_gains(shaft, chain.servo),
            "feed_forward": chain.feed_forward,
        }
        super().__init__(_layout(chain, machine), plant, self._law(self._controller))

    def _faults(self) -> dict[str, faults.Fault]:
        def load(plant: Drive, kilograms: float) -> None:
            self._weights[1] = kilograms

        payload = faults.Fault(
            name="payload",
            effect="inertia.payload",
            apply=load,
            strength=self._chain.payload,
            unit="kg",
        )
        return {**faults.of_drive(self._chain.nominal["coulomb_Nm"], "N m"), "payload": payload}

    def wake(self) -> None:
        """Controller at rest at the present reading, its integral holding the machine's nominal weight."""
        super().wake()
        self._before = np.zeros(len(self._before))
        self._held_weight = weight = self._believed.at(self.read())[2]
        self._memory[INTEGRAL] = weight / self._controller["ki_Nm_per_rad_s"]

    def brake(self) -> None:
        """Stand still without power."""
        super().brake()
        self._before = np.zeros(len(self._before))

    def _feed_forward(self, reference: Floats) -> Floats:
        """Nominal load at the reference beyond the one that the integral began with."""
        if self._controller["feed_forward"] == "none":
            return super()._feed_forward(reference)
        return np.asarray(self._believed.at(reference)[2] - self._held_weight)

    def _load_plant(self) -> None:
        """Inertia, velocity terms and weight in the middle of the coming sample; exact to its second order."""
        middle = self._q + 0.5 * self.layout.dt * self._v
        rate = self._v + 0.5 * (self._v - self._before)
        self._before = self._v.copy()
        inertia, velocity, weight = self._posture.at(middle)
        self._plant.inertia_inverse[:] = np.linalg.inv(self._own + inertia)
        self._plant.shaft[:, BIAS] = self._bias + weight + velocity @ rate @ rate

    def _law(self, controller: Mapping[str, Any]) -> LoopController:
        where = "configure, controller"
        given = Settings(where, controller, {*_gains(1.0, 1.0), "feed_forward"})
        for key, known in (("kind", ("pid",)), ("feed_forward", ("none", "load"))):
            if controller[key] not in known:
                raise InputError(f"{where}.{key}", repr(controller[key]), " or ".join(known))
        one = np.eye(len(self._chain.mark))
        kp, kd, ki, cutoff = (
            given.number(key, positive=True) for key in _gains(1.0, 1.0) if key != "kind"
        )
        return feedback(kp=kp * one, ki=ki * one, kd=kd * one, cutoff=cutoff, output=one)

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {"controller": dict(self._controller), "nominal": dict(self._nominal)}

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Use other gains or another nominal model."""
        new_controller = {**self._controller, **controller}
        new_nominal = {**self._nominal, **nominal}
        self._chain.machine(new_nominal)
        self.law = self._law(new_controller)
        self._controller, self._nominal = new_controller, new_nominal

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """All joints out and back together, every other one the opposite way, or the first alone."""
        n = len(self._chain.mark)
        signs = {
            "together": np.ones(n),
            "opposed": (-1.0) ** np.arange(n),
            "single": -np.eye(n)[0],
        }
        size = 0.8 * self._chain.travel / self._chain.per_motor
        return out_and_back(
            name, {k: size * v for k, v in signs.items()}, rate, cycles, self.layout.dt
        )

    def columns(self) -> dict[str, str]:
        """As in every log set of a parallel machine."""
        unit = KINDS[self._chain.kind].unit
        numbers = range(1, len(self._chain.mark) + 1)
        places = {f"q{i}{end}": unit for end in ("_ref", "") for i in numbers}
        return {"t": "s", **places, **{f"current{i}": "A" for i in numbers}}

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time, references, readings at the joints, currents."""
        constant = self._nominal["torque_constant_Nm_per_A"]
        axis = self.layout.axis
        return [time, *axis(reference), *axis(reading), *(command / constant)]

    def document(self) -> dict[str, Any]:
        """System and controller."""
        return {
            "system": {"kind": self._chain.kind, "nominal": dict(self._nominal)},
            "sample_time_s": self.layout.dt,
            "controller": dict(self._controller),
        }


def _gains(inertia: float, servo: float) -> dict[str, Any]:
    """A PID of bandwidth ``servo`` [rad/s] for an axis with its mean share of the machine [kg m^2]."""
    kp = inertia * servo**2
    return {
        "kind": "pid",
        "kp_Nm_per_rad": float(f"{kp:.3g}"),
        "kd_Nms_per_rad": float(f"{1.4 * inertia * servo:.3g}"),
        "ki_Nm_per_rad_s": float(f"{10.0 * kp:.3g}"),
        "derivative_filter_rad_per_s": 600.0,
    }


def _layout(chain: Chain, machine: ChainMachine) -> Layout:
    n, unit = len(chain.mark), KINDS[chain.kind].unit
    axes = tuple(
        Axis(
            name=name,
            unit=unit,
            speed=chain.speed,
            acceleration=4.0 * chain.speed,
            low=float(home - chain.travel),
            high=float(home + chain.travel),
        )
        for name, home in zip(machine.joints, chain.home)
    )
    return Layout(
        kind=chain.kind,
        motors=machine.joints,
        unit="rad",
        effort="N m",
        axes=axes,
        axis_map=chain.per_motor * np.eye(n),
        origin=chain.home,
        home=np.zeros(n),
        finds_switch=False,
        lsb=chain.count,
        following_error=0.3 * chain.travel / chain.per_motor,
    )
