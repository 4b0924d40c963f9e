"""The skeleton of any fixed-base tree of bodies: rods from joint to joint, thinner from body to body."""

import numpy as np

from ...models import rigid_tree
from ...models.rigid_tree import PRISMATIC, REVOLUTE
from ..gap.machines.model_file import Arm
from .skeletons import Coordinate, Floats, Skeleton

THICK, TAPER = (
    0.028,
    0.88,
)  # radius of the first rods over the machine's size, and from body to body
SHORT = 1e-3  # of the size: rods that are shorter are not drawn
EYE = np.array([0.8, -0.8, 0.45])  # from where one looks, in sizes off the centre


def tree_skeleton(name: str, arm: Arm, low: Floats, high: Floats, start: Floats) -> Skeleton:
    """Skeleton with one coordinate (rad or m) a joint, bounded by ``low`` and ``high`` (n,).

    A body without a child ends at twice its centre of mass; a sliding joint has a guide over its range.
    """
    kinematics = _Kinematics(arm, low, high)
    nodes = kinematics.place(start)
    points = np.concatenate([np.atleast_2d(p) for p in nodes.values()])
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    size = float(np.linalg.norm(np.ptp(points, axis=0))) or 1.0
    rods = [
        part
        for part, ends in nodes.items()
        if ends.ndim == 2 and np.linalg.norm(ends[1] - ends[0]) > SHORT * size
    ]
    balls = [part for part, ends in nodes.items() if ends.ndim == 1]

    def place(values: Floats) -> dict[str, Floats]:
        placed = kinematics.place(np.asarray(values, dtype=float))
        return {part: placed[part] for part in (*rods, *balls)}

    depth = kinematics.depth
    return Skeleton(
        name=name,
        coordinates=tuple(
            Coordinate(name=joint, unit="rad" if turns else "m", low=float(a), high=float(b),
                       start=float(min(max(q, a), b)))
            for joint, turns, a, b, q in zip(arm.joints, arm.revolute, low, high, start)
        ),
        rods={part: THICK * size * TAPER ** depth[part] for part in rods},
        balls={part: 1.4 * THICK * size * TAPER ** depth[part] for part in balls},
        place=place,
        camera=tuple(float(x) for x in centre + size * EYE),  # type: ignore[arg-type]
        centre=tuple(float(x) for x in centre),  # type: ignore[arg-type]
    )  # fmt: skip


class _Kinematics:
    """Where the parts of the skeleton are, by name: rods as ends (2, 3), balls as centres (3,)."""

    def __init__(self, arm: Arm, low: Floats, high: Floats) -> None:
        self._arm, self._low, self._high = arm, low, high
        parents = set(arm.tree.parent.tolist())
        self._leaves = [b for b in range(len(arm.bodies)) if b not in parents]
        self.depth: dict[str, int] = {}
        deep: list[int] = []
        for body, parent in enumerate(arm.tree.parent):
            deep.append(deep[parent] + 1 if parent >= 0 else 0)
            for kind in ("to", "joint of", "guide of", "end of"):
                self.depth[f"{kind} {arm.bodies[body]}"] = deep[body]

    def place(self, q: Floats) -> dict[str, Floats]:
        tree, found = self._arm.tree, {}
        frames: list[tuple[Floats, Floats]] = []  # rotation and origin of every body
        starts: list[Floats] = []  # where its joint is
        for body, name in enumerate(self._arm.bodies):
            parent, kind, column = tree.parent[body], tree.joint[body], tree.column[body]
            R, p = frames[parent] if parent >= 0 else (np.eye(3), np.zeros(3))
            origin = starts[parent] if parent >= 0 else np.zeros(3)
            joint, R_F = p + R @ tree.p_PF[body], R @ tree.R_PF[body]
            found[f"to {name}"] = np.stack([origin, joint])
            moved = joint
            if kind == PRISMATIC:
                axis = R_F @ tree.axis[body]
                span = np.array([self._low[column], self._high[column]])
                found[f"guide of {name}"] = joint + np.outer(span, axis)
                moved = joint + q[column] * axis
            if kind == REVOLUTE:
                turned = np.eye(3)
                rigid_tree.rotation(tree.axis[body], q[column], turned)
                R_F = R_F @ turned
            if column >= 0:
                found[f"joint of {name}"] = moved
            starts.append(moved)
            frames.append((R_F @ tree.R_MB[body], moved + R_F @ tree.p_MB[body]))
        for body in self._leaves:
            R, p = frames[body]
            mass, first = self._arm.inertia[body, 0], self._arm.inertia[body, 1:4]
            end = p + R @ (2.0 * first / mass if mass > 0.0 else np.zeros(3))
            found[f"end of {self._arm.bodies[body]}"] = np.stack([starts[body], end])
        return found
