"""Reading an URDF or SDF file with Drake, and what is refused."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ...errors import InputError
from .model_file import Arm, resolve_payload, turns


def parsed(
    path: Path,
    where: str,
    system: Mapping[str, Any],
    joints: tuple[str, ...],
    locked: Mapping[str, float],
) -> Arm:
    """The arm in a model file; InputError for what is not a fixed-base tree with these joints."""
    from ....systems.rigid_tree import tree_of

    plant = loaded(path, where, system)
    known = moving(plant)
    for name in (*joints, *locked):
        if name not in known:
            raise InputError(
                f"{where}.joints", f"the model has no joint {name!r} that moves",
                f"some of {', '.join(known)}",
            )  # fmt: skip
    try:
        tree, bodies, inertia = tree_of(plant, joints, locked)
    except ValueError as error:
        raise InputError(
            path, str(error), "a fixed-base tree of revolute and prismatic joints, all logged",
            "Weld a floating base by `system.base: LINK`, list joints that stand still in "
            "`system.locked: {JOINT: position}`.",
        ) from None  # fmt: skip
    carrier, place = resolve_payload(where, system, bodies, inertia)
    return Arm(
        tree=tree,
        bodies=bodies,
        inertia=inertia,
        joints=joints,
        revolute=turns(tree, len(joints)),
        damping=np.array(
            [float(plant.GetJointByName(j).default_damping_vector()[0]) for j in joints]
        ),
        gravity=np.array(plant.gravity_field().gravity_vector()),
        carrier=carrier,
        place=place,
    )


def loaded(path: Path, where: str, system: Mapping[str, Any]) -> Any:
    """The finalized MultibodyPlant of a model file, its ``system.base`` welded; InputError for another file."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(0.0)
    try:
        models = Parser(plant).AddModels(path)
        _weld_base(plant, system, where)
        plant.Finalize()
    except RuntimeError as error:
        raise InputError(
            path, f"Drake cannot read the model: {str(error).splitlines()[0][:300]}",
            "an arm as a tree of bodies: no closed loop",
        ) from None  # fmt: skip
    if len(models) != 1:
        raise InputError(path, f"{len(models)} models", "one model in the file")
    return plant


def moving(plant: Any) -> list[str]:
    """Names of the joints that move."""
    joints = [plant.get_joint(i) for i in plant.GetJointIndices()]
    return [joint.name() for joint in joints if joint.num_velocities()]


def _weld_base(plant: Any, system: Mapping[str, Any], where: str) -> None:
    base = system.get("base")
    if base is None:
        return
    if not plant.HasBodyNamed(str(base)):
        raise InputError(f"{where}.base", f"the model has no link {base!r}", "the name of its base")
    plant.WeldFrames(plant.world_frame(), plant.GetBodyByName(str(base)).body_frame())
