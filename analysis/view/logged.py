"""The picture of a log set's machine: its skeleton, and the skeleton's coordinates from the encoders' positions."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from ...models import c_drive
from ..errors import InputError
from ..gap.chain_machine import ChainMachine
from ..gap.result import Diagnosis
from .skeletons import Floats, Skeleton, skeleton

Coordinates = Callable[[Floats], Floats]
# Names of ``gapscope view`` by the kind of a log set.
NAMES = {
    "c_drive": "c-drive",
    "slider": "slider",
    "pmc": "pmc",
    "mm3a": "mm3a",
    "furuta": "furuta",
    "five_bar": "5r",
    "replalink": "replalink",
    "two_prr": "2prr",
    "mast": "mast",
    "three_prs": "3prs",
    "pendulum": "pendulum",
    "serial_arm": "arm",
}
MARGIN = 0.05  # of a model file's sliders beyond what was measured [rad or m]


def pictured(diagnosis: Diagnosis) -> tuple[Skeleton, Coordinates]:
    """Skeleton, and what turns positions (samples, n) of a run into its coordinates (samples, m).

    InputError for a machine that has no shape.
    """
    kind, machine = diagnosis.machine.kind, diagnosis.machine
    system = diagnosis.logset.system
    if kind == "model_file":
        return _model(diagnosis)
    if kind == "serial_arm":
        return skeleton("arm"), _by_name(machine.joints)
    if isinstance(machine, ChainMachine):
        ratio = machine.per_motor
        return _chain(kind, machine), lambda position: ratio * position
    if kind == "pendulum":
        from .servo_skeletons import pendulum

        return pendulum(float(system["length_m"])), _same
    if kind not in NAMES:
        raise InputError(
            "view", f"a {kind} has no shape to draw", f"a log of {', '.join(NAMES)} or a model file"
        )
    return skeleton(NAMES[kind]), _plain(kind, system)


def _plain(kind: str, system: Mapping[str, Any]) -> Coordinates:
    if kind == "c_drive":
        lead = float(system["nominal"].get("lead_m_per_rev", 0.060))
        return lambda position: c_drive.collar_pose(position, lead)
    if kind == "pmc":
        from ...models.pmc import constants

        home = np.asarray(system["home"])
        joint_map = constants.joint_map(float(system["nominal"]["drive"]["lead"]))
        return lambda position: np.asarray(home + position @ joint_map.T)
    return _same


def _same(position: Floats) -> Floats:
    return position


def _chain(kind: str, machine: ChainMachine) -> Skeleton:
    """With the lengths that the log set states."""
    from ...models.parallel.machine import FiveBarMachine, TwoPRRMachine
    from . import parallel_skeletons

    if isinstance(machine.chain, FiveBarMachine):
        return parallel_skeletons.linkage(NAMES[kind], machine.chain.geometry)
    if isinstance(machine.chain, TwoPRRMachine):
        return parallel_skeletons.slider_pair(machine.chain.geometry)
    return skeleton(NAMES[kind])


def _by_name(joints: tuple[str, ...]) -> Coordinates:
    """Columns of the arm that the log has, zero for the others; InputError for other joints."""
    from .servo_skeletons import SO101

    unknown = [joint for joint in joints if joint not in SO101]
    if unknown:
        raise InputError(
            "view", f"no picture of a joint {unknown[0]!r}", f"joints {', '.join(SO101)}"
        )
    columns = [SO101.index(joint) for joint in joints]

    def coordinates(position: Floats) -> Floats:
        found = np.zeros((len(position), len(SO101)))
        found[:, columns] = position
        return found

    return coordinates


def _model(diagnosis: Diagnosis) -> tuple[Skeleton, Coordinates]:
    from ..gap.machines.model_file import load_arm
    from .tree_skeleton import tree_skeleton

    position = np.concatenate([run.position for run in diagnosis.runs])
    low, high = position.min(axis=0) - MARGIN, position.max(axis=0) + MARGIN
    arm = load_arm(diagnosis.logset)
    name = str(diagnosis.logset.system["model"])
    return tree_skeleton(name, arm, low, high, position[0]), _same
