"""How a model file's robot is driven on the rig: joints, limits, home, loops, all stated where the file is silent.

1. joints: those named, or every joint that moves and is not locked; a root that floats is welded to the world;
2. limits of position, speed and effort are the file's; assumed where it has none: ``ROOM`` either way of zero, ``PACE``;
3. home: zero, or where the limits are near, a quarter of the travel inside them;
4. loops: PD with the nominal model's gravity, of bandwidth ``SERVO`` with the largest inertia that a joint sees.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...models.yaml_mapping import read_yaml_mapping
from ..errors import InputError
from ..gap.machines.model_file import KEYS, Arm, dry_friction
from ..gap.machines.settings import Settings
from .machine import Floats
from .setpoints import SHARPEST, STEEPEST

ROOM, PACE = {True: 1.5, False: 0.25}, {True: 1.5, False: 0.3}  # revolute (rad), prismatic (m)
COUNT = {True: 2.0 * np.pi / 2**16, False: 1e-6}  # of an encoder [rad or m]
SHARE = 0.35  # of the travel on the wider side of home, that a trajectory goes
SERVO = 30.0  # bandwidth of the loops [rad/s]
DAMPING = 0.9  # ratio of the loops
POSTURES = 200  # drawn for the largest inertia
FASTEST = 1.0  # of a trajectory to begin with [Hz]
SETTINGS = {"system", "controller", "sample_time_s", "home"}


@dataclass(frozen=True, kw_only=True)
class Drives:
    """What moves the joints, (n,) each [rad or m, seconds, N m or N]."""

    home: Floats
    low: Floats
    high: Floats
    speed: Floats
    effort: Floats  # infinite where the file states none
    lsb: Floats

    @property
    def reach(self) -> Floats:
        """Amplitude of a trajectory from home, towards the wider side."""
        wide = self.high - self.home >= self.home - self.low
        return SHARE * np.where(wide, self.high - self.home, self.low - self.home)

    @property
    def rate(self) -> float:
        """Of a trajectory that stays below half the speed limits [Hz], two digits."""
        peak = 2.0 * STEEPEST * np.abs(self.reach)  # speed at one cycle a second
        return float(f"{min(FASTEST, float(np.min(0.5 * self.speed / peak))):.1g}")

    def acceleration(self) -> Floats:
        """Largest acceleration of a trajectory at ``rate``."""
        return np.asarray(SHARPEST * np.abs(self.reach) * (2.0 * self.rate) ** 2)


def read_settings(path: Path | None) -> dict[str, Any]:
    """``system``, ``controller``, ``sample_time_s`` and ``home`` of a YAML file; InputError for other keys."""
    if path is None:
        return {}
    try:
        found = read_yaml_mapping(path)
    except (OSError, ValueError) as error:
        raise InputError(path, str(error), "a YAML file") from None
    Settings(str(path), found, SETTINGS)
    for key in ("system", "controller", "home"):
        if not isinstance(found.get(key, {}), dict):
            raise InputError(f"{path}, {key}", f"{found[key]!r}", "a mapping of keys to values")
    return dict(found)


def completed(
    path: Path, given: Mapping[str, Any], joints: Sequence[str] = ()
) -> tuple[dict[str, Any], Any]:
    """The log set's ``system`` block for a model file, with base and joints, and its plant.

    InputError for a file that is none, that needs others, or whose joints are not as named.
    """
    if path.suffix.lower() not in (".urdf", ".sdf") or not path.is_file():
        raise InputError(path, "no model file", "an .urdf or .sdf file")
    from ..gap.machines.model_plant import loaded, moving

    if "<include" in path.read_text(encoding="utf-8", errors="replace"):
        raise InputError(path, "the file includes others", "one file, for the log sets to keep")
    where = f"{path}, system"
    system = {**given, "model": path.name}
    Settings(where, system, KEYS)
    plant = loaded(path, where, system)
    root = _floating(plant)
    if "base" not in system and root is not None:
        system["base"] = root
        plant = loaded(path, where, system)
    known = moving(plant)
    locked = system.get("locked", {})
    named = list(joints) or system.get("joints")
    if not isinstance(locked, dict) or not (named is None or isinstance(named, list)):
        raise InputError(where, "joints or locked is malformed", "`joints: [...]`, `locked: {...}`")
    chosen = [str(j) for j in named] if named else [j for j in known if j not in locked]
    for name in chosen:
        if name not in known:
            raise InputError(f"{where}.joints", f"no joint {name!r} that moves", f"{known}")
        if "," in name or name == "t":
            raise InputError(f"{where}.joints", repr(name), "a name that can head a column")
    if not chosen or len(set(chosen)) != len(chosen):
        raise InputError(f"{where}.joints", f"{chosen}", "at least one joint, each once")
    system["joints"] = chosen
    still = {j: 0.0 for j in known if j not in chosen} | locked
    if still:
        system["locked"] = still
    return system, plant


def _floating(plant: Any) -> str | None:
    """The link that floats, if there is one."""
    for index in plant.GetJointIndices():
        joint = plant.get_joint(index)
        if joint.num_velocities() == 6:
            return str(joint.child_body().name())
    return None


def arm_of(path: Path, system: Mapping[str, Any]) -> Arm:
    """The model file as arrays."""
    from ..gap.machines.model_plant import parsed

    where = f"{path}, system"
    dry_friction(where, system)
    settings = Settings(f"{where}.locked", system.get("locked", {}), set(system.get("locked", {})))
    locked = {name: settings.number(name) for name in system.get("locked", {})}
    return parsed(path, where, system, tuple(system["joints"]), locked)


def drives_of(plant: Any, arm: Arm, home: Mapping[str, Any]) -> Drives:
    """Limits of the file where it has some; InputError for a home that is no place between them."""
    room, pace, lsb = (np.array([by[r] for r in arm.revolute]) for by in (ROOM, PACE, COUNT))
    joints = [plant.GetJointByName(name) for name in arm.joints]
    low = np.array([float(j.position_lower_limits()[0]) for j in joints])
    high = np.array([float(j.position_upper_limits()[0]) for j in joints])
    speed = np.array([float(j.velocity_upper_limits()[0]) for j in joints])
    low, high = (np.where(np.isfinite(x), x, s * room) for x, s in ((low, -1.0), (high, 1.0)))
    if not np.all(low < high):
        j = int(np.argmin(high - low))
        raise InputError(f"limits of {arm.joints[j]}", f"{low[j]:g} to {high[j]:g}", "room to move")
    middle = np.clip(0.0, low + 0.25 * (high - low), high - 0.25 * (high - low))
    settings = Settings("home", home, set(arm.joints))
    place = np.array([settings.number(n, float(q)) for n, q in zip(arm.joints, middle)])
    for name, q, a, b in zip(arm.joints, place, low, high):
        if not a < q < b:
            raise InputError(f"home.{name}", f"{q:g}", f"between its limits {a:g} and {b:g}")
    efforts = _efforts(plant)
    return Drives(
        home=lsb * np.round(place / lsb),
        low=low,
        high=high,
        speed=np.where(np.isfinite(speed) & (speed > 0.0), speed, pace),
        effort=np.array([efforts.get(name, np.inf) for name in arm.joints]),
        lsb=lsb,
    )


def _efforts(plant: Any) -> dict[str, float]:
    """Effort limits of the joints that have an actuator with one."""
    found = {}
    for index in plant.GetJointActuatorIndices():
        actuator = plant.get_joint_actuator(index)
        limit = float(actuator.effort_limit())
        if np.isfinite(limit) and limit > 0.0:
            found[str(actuator.joint().name())] = limit
    return found


def typical(arm: Arm, drives: Drives) -> tuple[Floats, Floats]:
    """Largest inertia (n,) that each joint sees in drawn postures, and its typical effort (n,)."""
    rng = np.random.default_rng(0)
    n = len(arm.joints)
    q = rng.uniform(drives.low, drives.high, (POSTURES, n))
    mass, _, load = arm.columns(q, np.zeros((POSTURES, n)))
    bodies = len(arm.bodies)
    inertia = np.max(np.einsum("skii->ski", mass[:, :bodies]).sum(axis=1), axis=0)
    weight = np.max(np.abs(load[:, :bodies].sum(axis=1)), axis=0)
    damping = arm.damping * np.abs(drives.reach) * 4.0 * STEEPEST * drives.rate * 0.5
    return inertia, weight + inertia * drives.acceleration() + damping


def gains(arm: Arm, drives: Drives, inertia: Floats) -> dict[str, Any]:
    """The controller block to begin with, three digits; InputError for a joint that moves nothing."""
    for name, size in zip(arm.joints, inertia):
        if not size > 0.0:
            raise InputError(f"joint {name}", "it moves no mass", "a model file with inertias")
    kp = np.maximum(inertia * SERVO**2, arm.damping * SERVO)
    kd = 2.0 * DAMPING * inertia * SERVO
    found: dict[str, Any] = {"kind": "joint_pd", "kp": _short(kp), "kd": _short(kd)}
    if np.all(np.isfinite(drives.effort)):
        found["limit"] = _short(drives.effort)
    return {**found, "gravity_compensation": True}


def _short(values: Floats) -> list[float]:
    return [float(f"{value:.3g}") for value in values]
