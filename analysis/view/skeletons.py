"""Machines as rods and balls: where each stands for given values of the machine's coordinates.

A rod keeps its length whatever the coordinates, so a renderer only moves it. Lengths in m, angles in rad, the world as in
the machine's model, planar machines in the plane z = 0.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..errors import InputError

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Coordinate:
    """One coordinate of a machine, moved by a slider."""

    name: str
    unit: str  # m or rad
    low: float
    high: float
    start: float


@dataclass(frozen=True, kw_only=True)
class Skeleton:
    """A machine to look at; ``place`` gives rods as ends (2, 3) and balls as centres (3,) [m], NaN out of reach."""

    name: str
    coordinates: tuple[Coordinate, ...]
    rods: Mapping[str, float]  # radius of each rod [m]
    balls: Mapping[str, float]  # radius of each ball [m]
    place: Callable[[Floats], dict[str, Floats]]
    camera: tuple[float, float, float]  # where the eye is [m]
    centre: tuple[float, float, float] = (0.0, 0.0, 0.0)  # what it looks at [m]

    @property
    def start(self) -> Floats:
        """Coordinates to begin with."""
        return np.array([coordinate.start for coordinate in self.coordinates])


def skeleton(name: str) -> Skeleton:
    """The machine of this name, or of this .urdf or .sdf file; InputError lists those that exist."""
    if Path(name).suffix.lower() in (".urdf", ".sdf"):
        return _model_file(Path(name))
    if name not in MACHINES:
        raise InputError(
            "view", f"unknown machine {name!r}", f"one of {', '.join(MACHINES)}, or a model file"
        )
    return MACHINES[name]()


def _model_file(path: Path) -> Skeleton:
    from ..rig.model_layout import arm_of, completed, drives_of
    from .tree_skeleton import tree_skeleton

    system, plant = completed(path, {})
    arm = arm_of(path, system)
    drives = drives_of(plant, arm, {})
    return tree_skeleton(path.name, arm, drives.low, drives.high, drives.home)


def _c_drive() -> Skeleton:
    half, arm = 0.25, 0.06

    def place(values: Floats) -> dict[str, Floats]:
        u, turn = values
        centre = np.array([u + 0.1, 0.0, 0.0])
        pointer = centre + arm * np.array([0.0, np.cos(turn), np.sin(turn)])
        ends = np.array([[-half, 0.0, 0.0], [half, 0.0, 0.0]])
        sleeve = centre + np.array([[-0.02, 0.0, 0.0], [0.02, 0.0, 0.0]])
        return {
            "screws": ends,
            "motor left": np.stack([ends[0] - [0.08, 0.0, 0.0], ends[0]]),
            "motor right": np.stack([ends[1], ends[1] + [0.08, 0.0, 0.0]]),
            "collar": sleeve,
            "pointer": np.stack([centre, pointer]),
            "mark": pointer,
        }

    return Skeleton(
        name="c-drive",
        coordinates=(
            Coordinate(name="slide u", unit="m", low=-0.2, high=0.0, start=-0.1),
            Coordinate(name="turn theta", unit="rad", low=-np.pi, high=np.pi, start=0.5),
        ),
        rods={
            "screws": 0.008,
            "motor left": 0.04,
            "motor right": 0.04,
            "collar": 0.03,
            "pointer": 0.006,
        },
        balls={"mark": 0.012},
        place=place,
        camera=(0.3, -0.6, 0.3),
    )


def _slider() -> Skeleton:
    def place(values: Floats) -> dict[str, Floats]:
        q = float(values[0])
        return {
            "screw": np.array([[-0.05, 0.0, 0.0], [0.35, 0.0, 0.0]]),
            "motor": np.array([[-0.15, 0.0, 0.0], [-0.05, 0.0, 0.0]]),
            "carriage": np.array([[q, -0.06, 0.03], [q, 0.06, 0.03]]),
        }

    return Skeleton(
        name="slider",
        coordinates=(Coordinate(name="position q", unit="m", low=-0.02, high=0.26, start=0.1),),
        rods={"screw": 0.008, "motor": 0.04, "carriage": 0.03},
        balls={},
        place=place,
        camera=(0.4, -0.6, 0.3),
        centre=(0.1, 0.0, 0.0),
    )


def _pmc() -> Skeleton:
    from ...models.pmc import kinematics, limits
    from ...models.pmc.geometry import Geometry

    g = Geometry()
    b, r = g.spacing, g.proximal

    def place(values: Floats) -> dict[str, Floats]:
        d1, d2, theta1, theta2 = values
        pose = kinematics.forward(values, g)
        x, y, z, phi = pose
        up = np.array([0.0, 0.0, 1.0])
        elbow1 = np.array([d1, r * np.cos(theta1), -b + r * np.sin(theta1)])
        alpha2 = 0.5 * np.pi - theta2
        elbow2 = np.array([r * np.cos(alpha2), d2, b + r * np.sin(alpha2)])
        centre = np.array([x, y, z])
        wrist1, wrist2 = centre + g.pitch * phi * up, centre - g.pitch * phi * up
        gripper = centre + 0.06 * np.array([np.cos(phi), -np.sin(phi), 0.0])
        carriage1, carriage2 = np.array([d1, 0.0, -b]), np.array([0.0, d2, b])
        return {
            "drive 1": np.array([[0.0, 0.0, -b], [0.6, 0.0, -b]]),
            "drive 2": np.array([[0.0, 0.0, b], [0.0, 0.6, b]]),
            "proximal 1": np.stack([carriage1, elbow1]),
            "proximal 2": np.stack([carriage2, elbow2]),
            "distal 1": np.stack([elbow1, wrist1]),
            "distal 2": np.stack([elbow2, wrist2]),
            "pepper mill": np.stack([centre - 0.3 * up, centre + 0.3 * up]),
            "gripper": np.stack([centre, gripper]),
            "wrist 1": wrist1,
            "wrist 2": wrist2,
            "carriage 1": carriage1,
            "carriage 2": carriage2,
        }

    theta = limits.theta_bounds(g)
    start = kinematics.inverse(np.array([0.299, 0.299, -0.2, g.centre_angle]), g)
    spans = [(g.carriage_min, g.carriage_max)] * 2 + list(theta)
    names = (
        ("carriage d1", "m"),
        ("carriage d2", "m"),
        ("crank theta1", "rad"),
        ("crank theta2", "rad"),
    )
    return Skeleton(
        name="pmc",
        coordinates=tuple(
            Coordinate(name=name, unit=unit, low=low, high=high, start=float(value))
            for (name, unit), (low, high), value in zip(names, spans, start)
        ),
        rods={"drive 1": 0.012, "drive 2": 0.012, "proximal 1": 0.014, "proximal 2": 0.014,
              "distal 1": 0.008, "distal 2": 0.008, "pepper mill": 0.008, "gripper": 0.01},
        balls={"wrist 1": 0.016, "wrist 2": 0.016, "carriage 1": 0.03, "carriage 2": 0.03},
        place=place,
        camera=(1.2, 1.0, 0.4),
        centre=(0.2, 0.2, -0.1),
    )  # fmt: skip


def _mm3a() -> Skeleton:
    from ...models.mm3a import kinematics
    from ...models.mm3a.arm import Arm

    arm = Arm()

    def place(values: Floats) -> dict[str, Floats]:
        c, s = np.cos(values[0]), np.sin(values[0])
        shoulder = np.array([arm.shoulder * c, arm.shoulder * s, 0.0])
        tip = np.array(kinematics.tip(values, arm))
        along = (tip - shoulder) / np.linalg.norm(tip - shoulder)
        return {
            "post": np.array([[0.0, 0.0, -0.015], [0.0, 0.0, 0.0]]),
            "shoulder": np.stack([np.zeros(3), shoulder]),
            "sleeve": np.stack([shoulder, shoulder + 0.02 * along]),
            "forearm": np.stack([tip - arm.forearm * along, tip]),
            "joint 2": shoulder,
            "tip": tip,
        }

    spans = ((arm.lower_1, arm.upper_1), (arm.lower_2, arm.upper_2), (arm.lower_3, arm.upper_3))
    return Skeleton(
        name="mm3a",
        coordinates=tuple(
            Coordinate(name=f"joint {i}", unit=unit, low=low, high=high, start=start)
            for i, (low, high), unit, start in zip(
                (1, 2, 3), spans, ("rad", "rad", "m"), (0.0, -0.5 * np.pi, 0.006)
            )
        ),
        rods={"post": 0.006, "shoulder": 0.004, "sleeve": 0.0035, "forearm": 0.0015},
        balls={"joint 2": 0.005, "tip": 0.002},
        place=place,
        camera=(0.06, -0.09, 0.05),
        centre=(0.02, 0.0, 0.0),
    )


def _furuta() -> Skeleton:
    from ...models.furuta import FurutaParameters

    p = FurutaParameters()

    def place(values: Floats) -> dict[str, Floats]:
        theta, alpha = values
        out = np.array([np.cos(theta), np.sin(theta), 0.0])
        ahead = np.array([-np.sin(theta), np.cos(theta), 0.0])
        up = np.array([0.0, 0.0, 1.0])
        elbow = p.L_r * out
        tip = elbow + p.L_p * (np.sin(alpha) * ahead + np.cos(alpha) * up)
        return {
            "motor": np.array([[0.0, 0.0, -0.1], [0.0, 0.0, -0.01]]),
            "arm": np.stack([np.zeros(3), elbow]),
            "pendulum": np.stack([elbow, tip]),
            "elbow": elbow,
        }

    return Skeleton(
        name="furuta",
        coordinates=(
            Coordinate(name="arm theta", unit="rad", low=-1.6, high=1.6, start=0.3),
            Coordinate(name="pendulum alpha", unit="rad", low=-np.pi, high=np.pi, start=0.2),
        ),
        rods={"motor": 0.03, "arm": 0.006, "pendulum": 0.005},
        balls={"elbow": 0.009},
        place=place,
        camera=(0.27, -0.2, 0.16),
    )


def _elsewhere(module: str, name: str) -> Callable[[], Skeleton]:
    def build() -> Skeleton:
        found: Skeleton = getattr(import_module(f".{module}", __package__), name)()
        return found

    return build


MACHINES: dict[str, Callable[[], Skeleton]] = {
    "c-drive": _c_drive,
    "slider": _slider,
    "pmc": _pmc,
    "mm3a": _mm3a,
    "5r": _elsewhere("parallel_skeletons", "five_bar_5r"),
    "replalink": _elsewhere("parallel_skeletons", "replalink"),
    "2prr": _elsewhere("parallel_skeletons", "slider_pair"),
    "mast": _elsewhere("parallel_skeletons", "mast"),
    "3prs": _elsewhere("parallel_skeletons", "three_prs"),
    "furuta": _furuta,
    "pendulum": _elsewhere("servo_skeletons", "pendulum"),
    "arm": _elsewhere("servo_skeletons", "so101"),
}
