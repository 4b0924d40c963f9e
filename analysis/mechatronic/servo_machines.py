"""The machines of ``gapscope simulate``, each with its diagram's settings, its motions and its log set's nominal model."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ...diagrams import five_bar_loop, mast_loop, replalink_loop, three_prs_loop, two_prr_loop
from ...diagrams.servo_loop import ServoLoop
from ...models.paths import Path as ToolPath
from ..errors import InputError


@dataclass(frozen=True, kw_only=True)
class ServoMachine:
    """One machine."""

    title: str
    loop: Callable[..., ServoLoop]  # settings, with defaults
    motions: dict[str, ToolPath]  # the first is the default
    gains: dict[str, float] = field(default_factory=dict)  # k_v that goes with a motion [1/s]
    kind: str  # of its log sets
    joint_unit: str  # rad or m
    nominal: Callable[[Any], dict[str, float]]  # of the machine, in ``system.nominal``


def servo_machine(name: str) -> ServoMachine:
    """The machine of that name; InputError lists the known ones."""
    if name not in MACHINES:
        raise InputError("machine", f"unknown name {name!r}", f"one of {', '.join(MACHINES)}")
    return MACHINES[name]


def motion(machine: ServoMachine, name: str | None) -> tuple[str, ToolPath]:
    """Name and path of a motion, by default the machine's first; InputError lists the known ones."""
    chosen = next(iter(machine.motions)) if name is None else name
    if chosen not in machine.motions:
        raise InputError(
            "--motion", f"unknown motion {chosen!r}", f"one of {', '.join(machine.motions)}"
        )
    return chosen, machine.motions[chosen]


def axis_nominal(loop: ServoLoop, joint_unit: str) -> dict[str, float]:
    """What ``system.nominal`` says of the axes; a belt's lead counts for a turn of the motor."""
    axis = loop.axis
    if joint_unit == "rad":
        gear = {"gear_ratio": 1.0 / axis.per_motor}
    else:
        gear = {"gear_ratio": 1.0, "lead_m_per_rev": 2.0 * np.pi * axis.per_motor}
    return {
        **gear,
        "torque_constant_Nm_per_A": axis.torque_constant,
        "rotor_inertia_kg_m2": axis.inertia,
        "viscous_Nms_per_rad": axis.viscous,
        "coulomb_Nm": axis.coulomb,
        "sign_width_rad_per_s": 1.0 / axis.sign_rate,
    }


def _five_bar(machine: Any) -> dict[str, float]:
    g = machine.geometry
    lengths = {f"{name}_m": getattr(g, name) for name in ("base", "crank1", "rod2", "rod3")}
    masses = {f"mass{i}_kg": m for i, m in enumerate(g.masses, start=1)}
    return {**lengths, "crank4_m": g.crank4, "tool_m": g.tool, **masses}


def _two_prr(machine: Any) -> dict[str, float]:
    g = machine.geometry
    lengths = {f"{name}_m": getattr(g, name) for name in ("span", "bar", "offset")}
    masses = {f"mass{i}_kg": m for i, m in enumerate(g.masses, start=1)}
    inertias = {f"inertia{i}_kg_m2": j for i, j in enumerate(g.bar_inertias, start=3)}
    return {**lengths, **masses, **inertias}


def _table(machine: Any) -> dict[str, float]:
    masses = {
        f"{name}_mass_kg": getattr(machine.table, f"{name}_mass")
        for name in ("platform", "bar", "carriage")
    }
    pulls = {} if machine.flexures is None else vars(machine.flexures)
    return {**masses, **{f"{name}_stiffness_Nm_per_rad": k for name, k in pulls.items()}}


MACHINES = {
    "5r": ServoMachine(
        title="Five-bar",
        loop=five_bar_loop.FiveBarLoop,
        motions=five_bar_loop.MOTIONS,
        gains=five_bar_loop.GAINS,
        kind="five_bar",
        joint_unit="rad",
        nominal=_five_bar,
    ),
    "2prr": ServoMachine(
        title="2-PRR",
        loop=two_prr_loop.TwoPRRLoop,
        motions=two_prr_loop.MOTIONS,
        kind="two_prr",
        joint_unit="m",
        nominal=_two_prr,
    ),
    "replalink": ServoMachine(
        title="RePlaLink",
        loop=replalink_loop.RePlaLinkLoop,
        motions=replalink_loop.MOTIONS,
        kind="replalink",
        joint_unit="rad",
        nominal=_five_bar,
    ),
    "mast": ServoMachine(
        title="2PRU-1PRS table",
        loop=mast_loop.MastLoop,
        motions=mast_loop.MOTIONS,
        kind="mast",
        joint_unit="m",
        nominal=_table,
    ),
    "3prs": ServoMachine(
        title="3-PRS table",
        loop=three_prs_loop.ThreePRSLoop,
        motions=three_prs_loop.MOTIONS,
        kind="three_prs",
        joint_unit="m",
        nominal=_table,
    ),
}
