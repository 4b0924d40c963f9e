"""Any fixed-base arm described by an URDF or SDF file (``system.model``), see README.md of this folder.

The file is read by Drake; its bodies become arrays that compiled loops run on. Every joint of
``system.joints`` has the columns ``JOINT`` (position, rad or m), perhaps ``JOINT_ref``, and
``JOINT_tau`` (N m or N) or ``JOINT_current`` (A, with ``system.torque_constant``). Efforts act at the
joint, behind any gear, and are commands held until the next sample unless ``system.effort`` is
``sampled``. Joints in ``system.passive`` have no motor, those in ``system.locked`` do not move.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ....models import rigid_tree_kernels
from ....models.joint import DRY, VISCOUS, WIDTH, ideal_joints
from ....models.rigid_tree import PARAMETERS, REVOLUTE, Tree
from ...errors import InputError
from ..checks import shown
from ..description import FILE
from ..logset import LogSet, Run
from ..machine import Array, RunData, encoder_step, own_parameter
from ..rigid_effects import SIGN_WIDTH, joint_forms
from ..rigid_machine import RigidMachine, RigidPlant, RigidRun, bandwidth_for, prepared
from .model_forms import mass_forms
from .pd_loop import JointPd, pd_controllers, replay, simulate
from .reference import derivatives
from .settings import Settings, require_units, run_settings, tolerance

KEYS = {"model", "joints", "base", "passive", "locked", "torque_constant", "effort", "payload",
        "coulomb", "tolerance", "limits", "description", "note", "kind"}  # fmt: skip
MOST_BANDWIDTH = 150.0  # rad/s
PAYLOAD = PARAMETERS  # of what the last body carries
TILTS = 2  # gravity along two horizontal directions [m/s^2]


@dataclass(frozen=True, kw_only=True)
class Arm:
    """A model file as arrays, with the groups of parameters that its equations are linear in.

    The groups are one factor for each body, ten parameters of a payload, two components of gravity.
    """

    tree: Tree
    bodies: tuple[str, ...]  # names
    inertia: Array  # (B, 10) standard parameters
    joints: tuple[str, ...]
    revolute: tuple[bool, ...]
    damping: Array  # (n,)
    gravity: Array  # (3,) [m/s^2]
    carrier: int  # number of the body that carries the payload
    place: Array  # (3,) of the payload, in its frame [m]

    @property
    def groups(self) -> Array:
        """Standard parameters (10 B, B + 10) per unit of the groups of mass."""
        size = self.inertia.size
        matrix = np.zeros((size, len(self.bodies) + PAYLOAD))
        for i, row in enumerate(self.inertia):
            matrix[PAYLOAD * i : PAYLOAD * (i + 1), i] = row
        first = PAYLOAD * self.carrier
        matrix[first : first + PAYLOAD, len(self.bodies) :] = np.eye(PAYLOAD)
        return matrix

    def columns(self, q: Array, v: Array) -> tuple[Array, Array, Array]:
        """Mass matrices (S, K, n, n), bias efforts and gravity loads (S, K, n) of the groups."""
        mass, bias, load = self._columns(self.groups, self.gravity, q, v)
        whole = self.inertia.reshape(-1, 1)
        tilts = [self._columns(whole, g, q, 0.0 * v)[2] for g in self.horizontal]
        none = np.zeros((len(q), TILTS, q.shape[1], q.shape[1]))
        return (
            np.concatenate([mass, none], axis=1),
            np.concatenate([bias, *tilts], axis=1),
            np.concatenate([load, *tilts], axis=1),
        )

    def _columns(self, groups: Array, g: Array, q: Array, v: Array) -> tuple[Array, Array, Array]:
        samples, n = q.shape
        K = groups.shape[1]
        out = np.empty((samples, K, n, n)), np.empty((samples, K, n)), np.empty((samples, K, n))
        q, v = np.ascontiguousarray(q), np.ascontiguousarray(v)
        rigid_tree_kernels.equation_columns(self.tree, groups, g, q, v, *out)
        return out

    @property
    def horizontal(self) -> tuple[Array, Array]:
        """Two unit vectors across gravity, in the world; x and y where gravity is along z."""
        size = np.linalg.norm(self.gravity)
        down = self.gravity / size if size > 0.0 else np.array([0.0, 0.0, -1.0])
        seed = np.eye(3)[0 if abs(down[0]) < 0.9 else 1]
        first = seed - (seed @ down) * down
        first /= np.linalg.norm(first)
        return first, np.cross(-down, first)


def read(logset: LogSet) -> tuple[RigidMachine, list[RunData]]:
    """Machine and runs of a log set with a model file; InputError says what does not fit."""
    where = f"{logset.folder / FILE}, system"
    Settings(where, logset.system, KEYS)
    arm = load_arm(logset)
    actuated, columns = _columns_of(logset, arm)
    laws = pd_controllers(logset, len(arm.joints), actuated == list(arm.joints))
    runs = [_run_data(run, logset, arm, columns, laws[run.controller]) for run in logset.runs]
    steps = np.max([[encoder_step(p[:, None]) for p in run.position.T] for run in runs], axis=0)
    bandwidth = bandwidth_for([r.position for r in runs], logset.dt, steps, MOST_BANDWIDTH)
    made = [prepared(run, arm.columns, bandwidth) for run in runs]
    machine = _machine(
        arm, actuated, made, bandwidth, tolerance(logset), dry_friction(where, logset.system)
    )
    return machine, list(made)


def dry_friction(where: str, system: Mapping[str, Any]) -> dict[str, float]:
    """Nominal dry friction [N m or N] by joint, ``system.coulomb``; model files have no place for it."""
    given = system.get("coulomb", {})
    if not isinstance(given, dict):
        raise InputError(f"{where}.coulomb", f"{given!r}", "levels by joint [N m or N]")
    settings = Settings(f"{where}.coulomb", given, set(map(str, system["joints"])))
    return {str(name): settings.number(name, positive=True) for name in given}


def load_arm(logset: LogSet) -> Arm:
    """The model file of a log set, relative to its folder."""
    where = f"{logset.folder / FILE}, system"
    system = logset.system
    name = system["model"]
    if not isinstance(name, str) or "\0" in name:
        raise InputError(f"{where}.model", shown(name), "the path of an .urdf or .sdf file")
    path = (logset.folder / name).resolve()
    if not path.is_file() or path.suffix not in (".urdf", ".sdf"):
        raise InputError(
            f"{where}.model", f"{name!r} is no model file (looked for {path})",
            "an .urdf or .sdf file, its path relative to the log set",
        )  # fmt: skip
    joints = system.get("joints")
    if not isinstance(joints, list) or not joints or len(set(map(str, joints))) != len(joints):
        raise InputError(
            f"{where}.joints", shown(joints), "the names of the logged joints, each once"
        )
    locked = system.get("locked", {})
    if not isinstance(locked, dict):
        raise InputError(f"{where}.locked", shown(locked), "positions by joint [rad or m]")
    settings = Settings(f"{where}.locked", locked, set(map(str, locked)))
    fixed = {str(name): settings.number(name) for name in locked}
    from .model_plant import parsed  # Drake is loaded for machines that need it only

    return parsed(path, where, system, tuple(map(str, joints)), fixed)


def _columns_of(logset: LogSet, arm: Arm) -> tuple[list[str], dict[str, tuple[str, float]]]:
    """Actuated joints, and the effort column of each with the effort per its unit."""
    where = f"{logset.folder / FILE}"
    passive = logset.system.get("passive", [])
    constants = logset.system.get("torque_constant", {})
    if not isinstance(passive, list) or not isinstance(constants, dict):
        raise InputError(
            f"{where}, system", "passive or torque_constant is malformed",
            "`passive: [JOINT, ...]` and `torque_constant: {JOINT: N m/A}`",
        )  # fmt: skip
    for joint in passive:
        if joint not in arm.joints:
            raise InputError(
                f"{where}, system.passive", shown(joint), f"some of {', '.join(arm.joints)}"
            )
    columns: dict[str, tuple[str, float]] = {}
    for joint, turns in zip(arm.joints, arm.revolute):
        unit = "rad" if turns else "m"
        referred = f"{joint}_ref" in logset.units
        require_units(logset, {joint: unit} | ({f"{joint}_ref": unit} if referred else {}))
        effort = "N m" if turns else "N"
        if f"{joint}_tau" in logset.units:
            require_units(logset, {f"{joint}_tau": effort})
            columns[joint] = (f"{joint}_tau", 1.0)
        elif f"{joint}_current" in logset.units:
            require_units(logset, {f"{joint}_current": "A"})
            given = Settings(f"{where}, system.torque_constant", constants, set(arm.joints))
            if joint not in constants:
                raise InputError(
                    f"{where}, system.torque_constant", f"nothing for {joint!r}",
                    f"its {effort} per ampere at the joint, behind the gear",
                )  # fmt: skip
            columns[joint] = (f"{joint}_current", _constant(given, joint))
        elif joint not in passive:
            raise InputError(
                f"{where}, columns", f"no effort of {joint!r}",
                f"`{joint}_tau: {effort}`, `{joint}_current: A`, or {joint} in system.passive",
            )  # fmt: skip
    if not columns:
        raise InputError(f"{where}, columns", "no joint has an effort", "at least one motor")
    return list(columns), columns


def _constant(given: Settings, joint: str) -> float:
    """Effort per ampere, negative where the motor is mounted the other way round."""
    constant = given.number(joint)
    if constant == 0.0:
        raise InputError(f"{given.where}.{joint}", "0", "an effort per ampere")
    return constant


def _run_data(
    run: Run,
    logset: LogSet,
    arm: Arm,
    columns: Mapping[str, tuple[str, float]],
    law: JointPd | None,
) -> RunData:
    position = run.stack(*arm.joints)
    has_reference = all(f"{joint}_ref" in run.columns for joint in arm.joints)
    reference = run.stack(*(f"{joint}_ref" for joint in arm.joints)) if has_reference else position
    rate, acceleration = derivatives(reference, logset.dt)
    command = run.stack(*(name for name, _ in columns.values()))
    command = np.ascontiguousarray(command * [constant for _, constant in columns.values()])
    kind = logset.system.get("effort", "held")
    if kind not in ("held", "sampled"):
        raise InputError(f"{logset.folder / FILE}, system.effort", shown(kind), "held or sampled")
    if kind == "sampled":  # as a held command with the same mean around every sample
        command = 0.5 * (command + np.concatenate([command[1:], command[-1:]]))
    settings = run_settings(logset, run)
    return RunData(
        name=run.name, use=run.use, settings=run.settings, dt=logset.dt, t=run.columns["t"],
        reference=reference, reference_rate=rate, reference_acceleration=acceleration,
        position=position, command=command, controller=law if has_reference else None,
        period=settings.period(logset.dt), lsb=encoder_step(position), start=settings.start,
    )  # fmt: skip


def _machine(
    arm: Arm,
    actuated: Sequence[str],
    runs: Sequence[RigidRun],
    bandwidth: float,
    relative: float,
    dry: Mapping[str, float],
) -> RigidMachine:
    rate = np.concatenate([run.rate[run.window] for run in runs])
    width = SIGN_WIDTH * np.maximum(np.sqrt(np.mean(rate**2, axis=0)), 1e-9)
    n = len(arm.joints)
    inputs = np.array([[float(a == j) for a in actuated] for j in arm.joints])
    damped = [(j, f"damping_{j}", d) for j, d in zip(arm.joints, arm.damping) if d > 0.0]
    heavy = [(i, f"mass_factor_{b}") for i, b in enumerate(arm.bodies) if arm.inertia[i, 0] > 0.0]

    def plant(values: Mapping[str, float]) -> RigidPlant:
        phi = np.zeros(len(arm.bodies) + PAYLOAD + TILTS)
        joints = ideal_joints(n, len(actuated), 1.0)
        joints.law[:, WIDTH] = width
        for i, name in heavy:
            phi[i] = values[name]
        for j, name in enumerate(arm.joints):
            joints.law[j, VISCOUS] = values.get(f"damping_{name}", 0.0)
            joints.law[j, DRY] = values.get(f"coulomb_{name}", 0.0)
        return RigidPlant(
            phi=phi, joints=joints, inputs=inputs, offset=np.zeros(n), scale=np.ones(n)
        )

    units = {"N m" if turns else "N" for turns in arm.revolute}
    return RigidMachine(
        kind="model_file",
        joints=arm.joints,
        actuated=tuple(actuated),
        position_unit="rad" if all(arm.revolute) else "m" if not any(arm.revolute) else "rad or m",
        effort_unit=" or ".join(sorted(units, reverse=True)),
        command_unit=" or ".join(sorted(units, reverse=True)),
        own=tuple(
            [own_parameter(name, "-", 1.0, relative) for _, name in heavy]
            + [own_parameter(name, "N m s/rad", d, relative) for _, name, d in damped]
            + [own_parameter(f"coulomb_{j}", "N m", level, relative) for j, level in dry.items()]
        ),
        damping={joint: name for joint, name, _ in damped},
        bandwidth=bandwidth,
        plant=plant,
        effects=lambda machine, runs: [*joint_forms(machine, runs), *mass_forms(arm)],
        loop=lambda run, plant: simulate(arm, run, plant),
        replayed=lambda runs: replay(arm, runs),
    )


def default_place(inertia: Array) -> Array:
    """Where a payload is looked for if the log set does not say: twice as far as the centre of mass."""
    return np.asarray(2.0 * inertia[1:4] / max(float(inertia[0]), 1e-12))


def resolve_payload(
    where: str, system: Mapping[str, Any], bodies: Sequence[str], inertia: Array
) -> tuple[int, Array]:
    """Number of the body that may carry a payload and where, from ``system.payload``."""
    given = system.get("payload", {})
    if not isinstance(given, dict):
        raise InputError(f"{where}.payload", shown(given), "`{body: LINK, point: [x, y, z]}` [m]")
    settings = Settings(f"{where}.payload", given, {"body", "point"})
    body = settings.text("body", bodies[-1])
    if body not in bodies:
        raise InputError(f"{where}.payload.body", f"{body!r}", f"one of {', '.join(bodies)}")
    number = list(bodies).index(body)
    return number, settings.numbers("point", 3, default_place(inertia[number]).tolist())


def turns(tree: Tree, joints: int) -> tuple[bool, ...]:
    """Whether each joint is revolute, in the order of q."""
    kinds = {int(c): int(k) for c, k in zip(tree.column, tree.joint) if c >= 0}
    return tuple(kinds[j] == REVOLUTE for j in range(joints))
