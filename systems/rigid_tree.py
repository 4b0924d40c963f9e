"""The tree of a MultibodyPlant as arrays that compiled loops read."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from pydrake.multibody.tree import JointIndex, PrismaticJoint, RevoluteJoint, WeldJoint

from ..models.rigid_tree import FIXED, PRISMATIC, REVOLUTE, Tree, standard_parameters


def tree_of(
    plant: Any, joints: Sequence[str], locked: Mapping[str, float]
) -> tuple[Tree, tuple[str, ...], np.ndarray]:
    """Tree, names of its bodies and their standard parameters (B, 10), of a finalized plant.

    ``joints`` are the moving ones in the order of q, ``locked`` the positions of others [rad or m].
    Raises ValueError for a tree that is not fixed to the world, for constraints that close loops, and
    for joints that move but are in neither, or have several degrees of freedom.
    """
    if plant.num_constraints() > 0:
        raise ValueError(
            f"the model has {plant.num_constraints()} constraints, which close loops or couple joints"
        )
    children: dict[int, list[Any]] = {}
    for index in plant.GetJointIndices():
        joint = plant.get_joint(JointIndex(index))
        children.setdefault(int(joint.parent_body().index()), []).append(joint)
    rows: list[tuple[Any, ...]] = []
    names: list[str] = []
    inertias: list[np.ndarray] = []
    waiting = [(int(plant.world_body().index()), -1)]
    while waiting:
        body, number = waiting.pop(0)
        for joint in children.get(body, []):
            rows.append((number, *_joint(joint, list(joints), locked)))
            child = joint.child_body()
            names.append(child.name())
            spatial = child.default_spatial_inertia()
            inertias.append(
                standard_parameters(
                    spatial.get_mass(),
                    spatial.get_com(),
                    spatial.CalcRotationalInertia().CopyToFullMatrix3(),
                )
            )
            waiting.append((int(child.index()), len(rows) - 1))
    parent, kind, column, axis, R_PF, p_PF, R_MB, p_MB = zip(*rows)
    tree = Tree(
        np.array(parent, dtype=np.int64), np.array(kind, dtype=np.int64),
        np.array(column, dtype=np.int64), np.array(axis, dtype=float), np.array(R_PF),
        np.array(p_PF), np.array(R_MB), np.array(p_MB),
    )  # fmt: skip
    return tree, tuple(names), np.array(inertias)


def _joint(joint: Any, joints: list[str], locked: Mapping[str, float]) -> tuple[Any, ...]:
    """Kind, column, axis and the frames X_PF, X_MB of a joint."""
    X_PF = joint.frame_on_parent().GetFixedPoseInBodyFrame()
    X_MB = joint.frame_on_child().GetFixedPoseInBodyFrame().inverse()
    axis: Any = np.array([0.0, 0.0, 1.0])
    if isinstance(joint, RevoluteJoint):
        kind, axis = REVOLUTE, joint.revolute_axis()
    elif isinstance(joint, PrismaticJoint):
        kind, axis = PRISMATIC, joint.translation_axis()
    elif isinstance(joint, WeldJoint):
        kind, X_PF = FIXED, X_PF.multiply(joint.X_FM())
    elif joint.num_velocities() == 6:
        raise ValueError(f"the body {joint.child_body().name()!r} floats: no joint fixes it")
    else:
        raise ValueError(
            f"the joint {joint.name()!r} is {joint.type_name()}: of several degrees of freedom"
        )
    column = -1
    if kind != FIXED and joint.name() in joints:
        column = joints.index(joint.name())
    elif kind != FIXED and joint.name() in locked:
        X_PF = X_PF.multiply(_moved(kind, axis, locked[joint.name()]))
        kind = FIXED
    elif kind != FIXED:
        raise ValueError(f"the joint {joint.name()!r} moves but is neither logged nor locked")
    return (
        kind, column, axis, X_PF.rotation().matrix(), X_PF.translation(),
        X_MB.rotation().matrix(), X_MB.translation(),
    )  # fmt: skip


def _moved(kind: int, axis: np.ndarray, position: float) -> Any:
    from pydrake.common.eigen_geometry import AngleAxis
    from pydrake.math import RigidTransform, RotationMatrix

    if kind == PRISMATIC:
        return RigidTransform(position * axis)
    return RigidTransform(RotationMatrix(AngleAxis(position, axis)), np.zeros(3))
