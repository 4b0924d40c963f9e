"""PD control of every joint, the control law a log set with a model file may state.

``controller: {kind: joint_pd, kp: [...], kd: [...], limit: [...], gravity_compensation: true}`` in the
order of ``system.joints``:  tau = kp e + kd (r' - D(q)) + g(q), D the difference over one sample, g the
nominal gravity load at the measured position. ``kind: unknown`` states no law.
"""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ....models import rigid_tree_kernels
from ...errors import InputError
from ..checks import shown
from ..clock import ReplayCheck
from ..description import FILE
from ..logset import LogSet
from ..machine import Array, RunData, rms
from ..rigid_machine import RigidPlant, RigidRun
from .settings import Settings

if TYPE_CHECKING:
    from .model_file import Arm

KEYS = {"kind", "kp", "kd", "limit", "gravity_compensation", "note"}
SUBSTEPS = 4


class JointPd(NamedTuple):
    """Gains (n,), effort limits (n,), and whether nominal gravity is compensated."""

    kp: Array
    kd: Array
    limit: Array
    gravity: bool


def pd_controllers(logset: LogSet, joints: int, all_driven: bool) -> dict[str, JointPd | None]:
    """Every stated controller by its id, None where no law is known."""
    return {
        name: joint_pd(f"{logset.folder / FILE}, controllers.{name}", given, joints, all_driven)
        for name, given in logset.controllers.items()
    }


def joint_pd(where: str, given: Mapping[str, Any], joints: int, all_driven: bool) -> JointPd | None:
    """The law of a ``controller`` block, None for ``kind: unknown``; InputError says what does not fit."""
    kind = given.get("kind")
    if kind == "unknown":
        return None
    if kind != "joint_pd":
        raise InputError(f"{where}.kind", shown(kind), "joint_pd or unknown")
    if not all_driven:
        raise InputError(where, "joint_pd with a passive joint", "kind: unknown")
    law = Settings(where, given, KEYS)
    limited = "limit" in given
    return JointPd(
        kp=law.numbers("kp", joints),
        kd=law.numbers("kd", joints),
        limit=law.numbers("limit", joints, above=0.0) if limited else np.full(joints, np.inf),
        gravity=law.flag("gravity_compensation"),
    )


def _compensation(arm: "Arm", law: JointPd) -> Array:
    return arm.inertia.ravel() * float(law.gravity)


def replay(arm: "Arm", runs: Sequence[RunData]) -> list[ReplayCheck]:
    """Every run's logged command beside the stated law's."""
    checks = []
    for blocks in runs:
        run = blocks.raw if isinstance(blocks, RigidRun) else blocks
        law = run.controller
        if law is None:
            continue
        command = np.empty_like(run.command)
        rigid_tree_kernels.replay_pd(
            arm.tree, arm.gravity, _compensation(arm, law), run.reference, run.reference_rate,
            run.position, law, run.dt, command,
        )  # fmt: skip
        size = rms([run.command]) or 1.0
        checks.append(ReplayCheck(run=run.name, disagreement=rms([command - run.command]) / size))
    return checks


def simulate(arm: "Arm", run: RunData, plant: RigidPlant) -> tuple[Array, Array] | None:
    """Position and command (samples, n) of the closed loop on the run's reference."""
    law = run.controller
    if law is None or np.any(plant.offset != 0.0) or np.any(plant.scale != 1.0):
        return None
    assert isinstance(run, RigidRun)
    bodies = len(arm.bodies)
    first, second = arm.horizontal
    tilt = plant.phi[-2] * first + plant.phi[-1] * second
    start = np.concatenate([run.smooth[0], run.rate[0]])
    run = run.raw
    position, command = np.empty_like(run.position), np.zeros_like(run.command)
    rigid_tree_kernels.simulate_pd(
        arm.tree, arm.gravity + tilt, arm.groups @ plant.phi[: bodies + 10], arm.gravity,
        _compensation(arm, law), plant.joints, run.reference, run.reference_rate, start, law,
        run.lsb, run.dt, SUBSTEPS, position, command,
    )  # fmt: skip
    return position, command
