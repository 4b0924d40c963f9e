"""A robot of one's own behind the rig: any URDF or SDF file that is a tree on a fixed base (``system.model``).

Plant: the file's bodies in the equations of ``models.rigid_tree``, in time by the kernel of the instrument's own closed
loop, with a fault; controller and log are ``joint_pd`` and columns of such a log set. The nominal model is a file, too:
``configure`` takes another one with the same joints under ``model``, and dry friction, which no model file states, under
``coulomb``. It homes where it stands, brought there by hand. Not modelled: collisions, gears, joints that bend.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...models import joint, rigid_tree_kernels
from ...models.joint import Joints
from ...models.rigid_tree import PARAMETERS, point_mass
from ..errors import InputError
from ..gap.machines.model_file import Arm, dry_friction
from ..gap.machines.pd_loop import JointPd, joint_pd
from ..gap.machines.settings import Settings
from . import faults
from .encoders import Encoders
from .machine import Axis, Floats, Layout, Trajectory
from .model_layout import Drives, arm_of, completed, drives_of, gains, read_settings, typical
from .setpoints import out_and_back

DT = 0.002  # [s]
SUBSTEPS = 4
HISTORY = 64  # samples of commands kept for a delay
SIGN_WIDTH = 0.008  # of the smoothed sign of dry friction, as a share of the speed limit


class Plant:
    """What effects act on: bodies, joints and actuators."""

    def __init__(self, arm: Arm, width: Floats, effort: Floats) -> None:
        self.arm, self.effort = arm, effort  # typical efforts (n,)
        self.phi = arm.inertia.ravel().copy()
        self.joints: Joints = joint.ideal_joints(len(arm.joints), len(arm.joints), 1.0)
        self.joints.law[:, joint.WIDTH] = width
        self.joints.law[:, joint.VISCOUS] = arm.damping

    def carry(self, mass: float) -> None:
        """A point mass where the log set says that a payload is."""
        first = PARAMETERS * self.arm.carrier
        self.phi[first : first + PARAMETERS] += mass * point_mass(self.arm.place)


class ModelArm:
    """The robot of a model file with a fault, under PD loops with gravity compensation."""

    def __init__(
        self,
        path: Path,
        fault: str = "none",
        seed: int = 0,
        *,
        joints: Sequence[str] = (),
        settings: Path | None = None,
    ) -> None:
        given = read_settings(settings)
        self._system, plant = completed(path, given.get("system", {}), joints)
        self._path, self._arm = path, arm_of(path, self._system)
        drives = drives_of(plant, self._arm, given.get("home", {}))
        inertia, effort = typical(self._arm, drives)
        self._plant = Plant(self._arm, SIGN_WIDTH * drives.speed, effort)
        heavy = sum(row[0] for row in self._arm.inertia[1:]) or self._arm.inertia[0, 0]
        self.answer = faults.give(fault, self._plant, _faults(float(heavy)), seed)
        self._nominal: dict[str, Any] = {"model": str(path)}
        if "coulomb" in self._system:
            self._nominal["coulomb"] = self._system.pop("coulomb")
        self._believed = self._arm
        self._texts = path.read_text(encoding="utf-8")
        self._controller = {**gains(self._arm, drives, inertia), **given.get("controller", {})}
        self._law = self._read_law(self._controller)
        dt = Settings("sample_time_s", given, set(given)).number("sample_time_s", DT, positive=True)
        self.layout = _layout(self._arm, drives, dt)
        self.programs: Sequence[str] = tuple(_programs(self._arm, drives))
        self._drives = drives
        self._encoders = Encoders(len(self._arm.joints), drives.lsb)
        self._x = np.concatenate([drives.home, 0.0 * drives.home])
        self._scratch = np.zeros((len(self._arm.joints), self._plant.phi.size))
        self.wake()

    def power_up(self, rng: np.random.Generator) -> None:
        """Stand at home, where somebody has brought it."""
        self._x = np.concatenate([self.layout.home, 0.0 * self.layout.home])
        self.preset(self.layout.home)
        self.wake()

    def read(self) -> Floats:
        """Encoder readings (joints,) [rad or m]."""
        return self._encoders.read(self.true_axes())

    def preset(self, motors: Floats) -> None:
        """Let the encoders read ``motors`` here."""
        self._encoders.preset(self.true_axes(), motors)

    def true_axes(self) -> Floats:
        """Where the joints really are (joints,)."""
        return np.asarray(self._x[: len(self._arm.joints)].copy())

    def wake(self) -> None:
        """Loops without memory, at rest at the present reading, the weight held."""
        n = len(self._arm.joints)
        self._before = self.read()
        self._wanted: Floats | None = None
        weight = self._law_of(self._before, np.zeros(n), self._before)
        self._command, self._effort = np.tile(weight, (HISTORY, 1)), weight.copy()

    def step(self, reference: Floats, acceleration: Floats) -> Floats:
        """Loops and robot of one sample; the efforts asked for (joints,)."""
        dt = self.layout.dt
        rate = np.zeros(len(reference))
        if self._wanted is not None:
            rate = (reference - self._wanted) / dt + 0.5 * dt * acceleration
        self._wanted = np.array(reference)
        reading = self.read()
        self._command[:-1] = self._command[1:]
        self._command[-1] = self._law_of(np.asarray(reference, dtype=float), rate, reading)
        self._before = reading
        plant = self._plant
        rigid_tree_kernels.advance(
            self._arm.tree, self._arm.gravity, plant.phi, plant.joints, self._command, HISTORY - 1,
            self._x, self._effort, dt, SUBSTEPS, self._scratch,
        )  # fmt: skip
        return self._command[-1].copy()

    def brake(self) -> None:
        """Stand still without power."""
        self._x[len(self._arm.joints) :] = 0.0

    def settings(self) -> dict[str, Any]:
        """Blocks in use."""
        return {"controller": dict(self._controller), "nominal": dict(self._nominal)}

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Other gains, another model file with these joints, nominal dry friction by joint."""
        new_controller = {**self._controller, **controller}
        new_nominal = {**self._nominal, **nominal}
        Settings("configure, nominal", new_nominal, {"model", "coulomb"})
        path = Path(str(new_nominal["model"]))
        dry_friction("configure, nominal", {**self._system, **new_nominal})
        system, _ = completed(path, {k: v for k, v in self._system.items() if k != "model"})
        believed = arm_of(path, system)
        self._law = self._read_law(new_controller)
        self._path, self._believed, self._system = path, believed, system
        self._texts = path.read_text(encoding="utf-8")
        self._controller, self._nominal = new_controller, new_nominal

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """All joints out and back together, every other one the opposite way, or one alone."""
        found = out_and_back(name, _programs(self._arm, self._drives), rate, cycles, self.layout.dt)
        return Trajectory(
            name=found.name,
            position=self.layout.home + found.position,
            acceleration=found.acceleration,
            keys=found.keys,
        )

    def columns(self) -> dict[str, str]:
        """As in every log set of a model file."""
        kinds = list(zip(self._arm.joints, self._arm.revolute))
        places = {f"{j}{end}": "rad" if r else "m" for end in ("_ref", "") for j, r in kinds}
        return {"t": "s", **places, **{f"{j}_tau": "N m" if r else "N" for j, r in kinds}}

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """Time, references, readings, efforts."""
        return [time, *reference, *reading, *command]

    def document(self) -> dict[str, Any]:
        """System and controller."""
        dry = {k: v for k, v in self._nominal.items() if k == "coulomb" and v}
        return {
            "system": {**self._system, **dry},
            "sample_time_s": self.layout.dt,
            "controller": dict(self._controller),
        }

    def files(self) -> Mapping[str, str]:
        """The nominal model file."""
        return {self._path.name: self._texts}

    def _read_law(self, controller: Mapping[str, Any]) -> JointPd:
        law = joint_pd("configure, controller", controller, len(self._arm.joints), True)
        if law is None:
            raise InputError("configure, controller.kind", "unknown", "joint_pd")
        return law

    def _law_of(self, reference: Floats, rate: Floats, reading: Floats) -> Floats:
        arm = self._believed
        out = np.zeros(len(arm.joints))
        carried = arm.inertia.ravel() * float(self._law.gravity)
        rigid_tree_kernels.pd_command(
            arm.tree, arm.gravity, carried, reference, rate, reading, self._before, self._law,
            self.layout.dt, np.zeros((len(out), carried.size)), out,
        )  # fmt: skip
        return out


def _programs(arm: Arm, drives: Drives) -> dict[str, Floats]:
    """Amplitudes by name: all joints, every other one the opposite way and less far, each alone."""
    reach, n = drives.reach, len(arm.joints)
    opposed = np.where(np.arange(n) % 2 == 1, -0.5, 1.0) * reach
    found = {"together": reach, "opposed": opposed}
    alone = {f"{name} alone": reach * row for name, row in zip(arm.joints, np.eye(n))}
    return {**found, **alone} if n > 1 else {"together": reach}


def _faults(mass: float) -> dict[str, faults.Fault]:
    def rub(plant: Plant, share: float) -> None:
        plant.joints.law[:, joint.DRY] += share * plant.effort

    def one(plant: Plant, share: float) -> None:
        plant.joints.law[0, joint.DRY] += share * plant.effort[0]

    def weak(plant: Plant, gain: float) -> None:
        plant.joints.actuator[:, joint.GAIN] = gain

    def late(plant: Plant, seconds: float) -> None:
        plant.joints.actuator[:, joint.DELAY] = seconds

    found = (
        faults.Fault(name="friction", effect="friction.coulomb", apply=rub,
                     strength=(0.05, 0.15), unit="of each joint's typical effort"),
        faults.Fault(name="bearing", effect="friction.coulomb", apply=one,
                     strength=(0.1, 0.2), unit="of the first joint's typical effort"),
        faults.Fault(name="payload", effect="inertia.payload", apply=Plant.carry,
                     strength=(0.1 * mass, 0.25 * mass), unit="kg"),
        faults.Fault(name="weak", effect="actuator.torque_constant", apply=weak,
                     strength=(0.75, 0.9), unit="-"),
        faults.Fault(name="delay", effect="actuator.delay", apply=late,
                     strength=(0.004, 0.01), unit="s"),
    )  # fmt: skip
    return {fault.name: fault for fault in found}


def _layout(arm: Arm, drives: Drives, dt: float) -> Layout:
    n = len(arm.joints)
    units = ["rad" if turns else "m" for turns in arm.revolute]
    efforts = sorted({"N m" if turns else "N" for turns in arm.revolute}, reverse=True)
    return Layout(
        kind="model_file",
        motors=arm.joints,
        unit=" or ".join(sorted(set(units), reverse=True)),
        effort=" or ".join(efforts),
        axes=tuple(
            Axis(name=name, unit=unit, speed=float(v), acceleration=float(4.0 * v), low=float(a),
                 high=float(b))
            for name, unit, v, a, b in zip(
                arm.joints, units, 0.5 * drives.speed, drives.low, drives.high
            )
        ),
        axis_map=np.eye(n),
        origin=np.zeros(n),
        home=drives.home,
        finds_switch=False,
        lsb=drives.lsb,
        following_error=0.2 * (drives.high - drives.low),
        dt=dt,
        rate=drives.rate,
    )  # fmt: skip
