"""Nominal model of an arm of position servos (``system.kind: serial_arm``): every joint follows its reference.

Each joint is a servo of its own (``models/position_servo.py``), simulated from its logged reference and
the first measured angle alone: nothing corrects the simulation, so that a sag at rest is seen in full. Nominal
servos carry no load and have no dry friction. ``system.nominal`` may state ``time_constant_s``,
``inertia_s2`` and ``delay_s``; what it leaves out is that of the STS3215 servo in the MuJoCo model of the
Open Duck Mini (kp 17.8 N m/rad, damping 0.60 N m s/rad, armature 0.028 kg m^2) with one sample of delay, each
between zero and ``LOOSE`` times that: their firmware gains are others.

Loads that turn with the arm are evaluated at the measured angles. ``system.parallel_axes`` lists the joints
whose axes are parallel and horizontal, from the base outwards, with a minus sign where an axis points the
other way; arms whose joints are named as those of the SO-101 need not state it. Nothing else is
known of the arm's kinematics: which joints a load is found at is up to the data.

Residuals are taken every ``EVERY`` samples. An unsigned torque that is logged is compared with what is
found (``servo_torque.py``).

Not tried on this machine: friction that falls with speed, end stops and collisions, torque ripple, compliance behind the servo, thermal drift, forces of motion
between the joints.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....models import position_servo_kernel
from ....models.position_servo import PositionServo, ideal_servo
from ...errors import InputError
from ..checks import shown
from ..description import FILE
from ..logset import LogSet, Run
from ..machine import Array, Machine, Parameter, RunData, encoder_step, own_parameter
from .reference import derivatives
from .repeated import repeated_floor
from .servo_torque import torque_remarks
from .settings import (
    Settings,
    require_controllers,
    require_sizes,
    require_units,
    run_settings,
    tolerance,
)

if TYPE_CHECKING:
    from ..effects import Form

TIME_CONSTANT = 0.60 / 17.8  # [s]
INERTIA = 0.028 / 17.8  # [s^2]
LOOSE = 4.0  # of values that somebody else's servo had
SUBSTEPS = 4  # of the simulation, per sample
EVERY = 5  # samples from one residual to the next
SO101 = ("pitch", "elbow", "wrist_pitch")  # parallel axes, all pointing the same way
SHORTEST = 50  # samples of a run
TORQUE = re.compile(r"N ?m( from .+)?")  # unit, perhaps with what it was worked out from
KEYS = {"kind", "joints", "servo", "parallel_axes", "nominal", "tolerance", "limits", "note",
        "description"}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class ArmRun(RunData):
    """Every ``EVERY``-th sample of a run, and what the simulation needs of all samples."""

    fine_reference: Array  # (joints, fine) [rad]
    fine_position: Array  # (joints, fine) [rad]
    link_angles: Array  # (links, fine) of the joints with parallel axes, summed from the base [rad]
    fine_dt: float  # [s]
    torque: Array | None  # (fine, joints) magnitude [N m], None where it is not logged


@dataclass
class ArmPlant:
    """The servos and loads that effects act on."""

    servos: list[PositionServo]
    bias: Array  # (joints,) constant load [rad]
    turning: Array  # (joints, links, 2) load by cosine and sine of the links' angles [rad]
    time: float = 0.0

    def change(self, joint: int, **fields: float) -> None:
        """Replace constants of one servo."""
        self.servos[joint] = self.servos[joint]._replace(**fields)

    def change_all(self, **fields: float) -> None:
        """Replace constants of every servo."""
        self.servos = [servo._replace(**fields) for servo in self.servos]

    def load(self, joint: int, run: ArmRun) -> Array:
        """Load (fine,) [rad] of a joint at the measured angles."""
        found = np.full(run.fine_reference.shape[1], self.bias[joint])
        for by_link, angle in zip(self.turning[joint], run.link_angles):
            if np.any(by_link):
                found += by_link[0] * np.cos(angle) + by_link[1] * np.sin(angle)
        return found

    def finished(self) -> "ArmPlant":
        """Itself."""
        return self


@dataclass(frozen=True, kw_only=True)
class ArmMachine(Machine):
    """An arm of position servos, predicted by simulating each from its reference."""

    chain: tuple[tuple[int, float], ...]  # joints with parallel axes from the base, with signs

    def build(self, values: Mapping[str, float]) -> ArmPlant:
        """Servos without load and dry friction at the own parameters' values."""
        servos = [
            ideal_servo(values[f"time_constant_{j}"], values["inertia"], values["delay"])
            for j in self.joints
        ]
        count = len(self.joints)
        return ArmPlant(
            servos=servos, bias=np.zeros(count), turning=np.zeros((count, len(self.chain), 2))
        )

    def predict(self, run: RunData, plant: ArmPlant) -> Array:
        """Measured less simulated angle (samples, joints) over the run's window [rad]."""
        assert isinstance(run, ArmRun)
        simulated = np.empty((len(self.joints), len(run.t)))
        simulated[:, 0] = run.fine_position[:, 0]
        for j, servo in enumerate(plant.servos):
            position_servo_kernel.simulate(
                run.fine_reference[j], plant.load(j, run), servo, run.fine_dt, SUBSTEPS, EVERY,
                simulated[j],
            )  # fmt: skip
        return np.asarray((run.position - simulated.T)[run.window])

    def forms(self, runs: Sequence[RunData]) -> "list[Form]":
        """Loads, friction of the gears, flaws of the servos, clearance and encoders behind them."""
        from .serial_arm_forms import arm_forms  # the effects' base names other machines

        return arm_forms(self, [run for run in runs if isinstance(run, ArmRun)])

    def floor(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> tuple[list[Array], str]:
        """What does not repeat where the references of all joints repeat; else the encoder's step."""
        return repeated_floor(runs, residuals)

    def remarks(self, runs: Sequence[RunData]) -> list[str]:
        """The torque at rest by joint, and whether the servos act on the logged error."""
        return torque_remarks(self.joints, [run for run in runs if isinstance(run, ArmRun)])


def read(logset: LogSet) -> tuple[Machine, list[RunData]]:
    """Machine and runs of an arm's log set."""
    where = f"{logset.folder / FILE}, system"
    joints = _joints(logset.system.get("joints"), where)
    require_units(logset, {n: "rad" for joint in joints for n in (f"{joint}_ref", joint)})
    logged = [f"{joint}_abs_torque" in logset.units for joint in joints]
    if any(logged):
        _require_torques(logset, joints)
    require_controllers(logset, "servo_position")
    Settings(where, logset.system, KEYS)
    chain = _chain(logset.system.get("parallel_axes"), joints, where)
    machine = ArmMachine(
        kind="serial_arm",
        joints=joints,
        position_unit="rad",
        effort_unit="rad",
        own=tuple(_own(logset, joints)),
        chain=chain,
    )
    return machine, [_run(run, logset, machine, any(logged)) for run in logset.runs]


def _joints(value: Any, where: str) -> tuple[str, ...]:
    names = value if isinstance(value, list) else []
    if not names or not all(isinstance(n, str) for n in names) or len(set(names)) < len(names):
        raise InputError(f"{where}.joints", shown(value), "a list of the joints' names, each once")
    return tuple(names)


def _require_torques(logset: LogSet, joints: Sequence[str]) -> None:
    for joint in joints:
        name = f"{joint}_abs_torque"
        unit = logset.units.get(name, "")
        if not TORQUE.fullmatch(unit):
            raise InputError(
                f"{logset.folder / FILE}, columns.{name}",
                f"the unit is {unit!r}" if unit else "no such column",
                "`N m`, the magnitude of the servo's torque, of every joint or of none",
            )
        require_sizes(logset, name)


def _chain(value: Any, joints: Sequence[str], where: str) -> tuple[tuple[int, float], ...]:
    """Joints with parallel axes as (index, sign)."""
    if value is None:
        value = list(SO101) if set(SO101) <= set(joints) else []
    expected = f"a list of names out of {', '.join(joints)}, a minus sign before a reversed one"
    if not isinstance(value, list) or not all(isinstance(name, str) for name in value):
        raise InputError(f"{where}.parallel_axes", shown(value), expected)
    names = [name.removeprefix("-") for name in value]
    for name in names:
        if name not in joints or names.count(name) > 1:
            raise InputError(f"{where}.parallel_axes", f"{name!r}", expected)
    return tuple(
        (joints.index(n), -1.0 if v.startswith("-") else 1.0) for n, v in zip(names, value)
    )


def _own(logset: LogSet, joints: Sequence[str]) -> list[Parameter]:
    """Time constants of the joints, and the inertia and delay that all share."""
    stated = logset.system.get("nominal", {})
    where = f"{logset.folder / FILE}, system.nominal"
    if not isinstance(stated, dict):
        raise InputError(where, shown(stated), "a mapping of parameters")
    nominal = Settings(where, stated, {"time_constant_s", "inertia_s2", "delay_s", "note"})
    relative = tolerance(logset)

    def own(name: str, key: str, unit: str, otherwise: float) -> Parameter:
        value = nominal.number(key, otherwise, positive=True)
        if key in stated:
            return own_parameter(name, unit, value, relative)
        return Parameter(
            name=name, unit=unit, lower=0.0, upper=LOOSE * value, scale=value, starts=(value,)
        )

    return [
        *(own(f"time_constant_{j}", "time_constant_s", "s", TIME_CONSTANT) for j in joints),
        own("inertia", "inertia_s2", "s^2", INERTIA),
        own("delay", "delay_s", "s", logset.dt),
    ]


def _run(run: Run, logset: LogSet, machine: ArmMachine, with_torque: bool) -> ArmRun:
    settings = run_settings(logset, run)  # repeated stretches are found, whatever period is stated
    if run.samples < SHORTEST:
        raise InputError(run.name, f"{run.samples} samples", f"at least {SHORTEST} of an arm")
    joints = machine.joints
    position, reference = run.stack(*joints), run.stack(*(f"{j}_ref" for j in joints))
    rate, acceleration = derivatives(reference, logset.dt)
    links = [sign * position[:, j] for j, sign in machine.chain]
    return ArmRun(
        name=run.name,
        use=run.use,
        settings=run.settings,
        dt=EVERY * logset.dt,
        t=(run.columns["t"] - run.columns["t"][0])[::EVERY],
        reference=reference[::EVERY],
        reference_rate=rate[::EVERY],
        reference_acceleration=acceleration[::EVERY],
        position=position[::EVERY],
        command=reference[::EVERY],
        controller=None,
        period=None,
        lsb=max((encoder_step(column) for column in position.T), default=0.0),
        start=settings.start,
        fine_reference=np.ascontiguousarray(reference.T),
        fine_position=np.ascontiguousarray(position.T),
        link_angles=np.cumsum(links, axis=0) if links else np.zeros((0, len(position))),
        fine_dt=logset.dt,
        torque=run.stack(*(f"{j}_abs_torque" for j in joints)) if with_torque else None,
    )
