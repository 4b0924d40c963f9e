"""Pictures of the C-drive benchmark in the manner of Friedlaender 2015, Figs. 5-1 and 5-2."""

from collections.abc import Sequence
from functools import cache

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ..models import benchmark, c_drive, motion, thesis_tables
from ..models.benchmark import BenchmarkRun, Conditions
from ..models.c_drive import CDriveParameters
from .comparison import MODEL_FACTOR, ComparedRow
from .figures import BLUE, GREEN, ORANGE, PURPLE, VERMILION, ink

COLOURS = {"pd": VERMILION, "ct": BLUE, "ts": GREEN}
LABELS = {"pd": "PD", "ct": "CT", "ts": "TS"}
UNITS = {
    thesis_tables.TAU_RMS: "torque",
    thesis_tables.E_U_RMS: "translation error",
    thesis_tables.E_THETA_RMS: "rotation error",
}


def motion_programs() -> Figure:
    """Fig. 5-1 a-d: the polynomial with its normalised derivatives, and the three motions."""
    figure, axes = plt.subplots(1, 4, figsize=(11.0, 2.5))
    cycle = np.linspace(0.0, 0.5, 501)
    tau = np.clip(2.0 * np.minimum(cycle, 0.5 - cycle) / 0.5, 0.0, 1.0)
    s, ds, dds = motion.polynomial_4567(tau)
    back = np.where(cycle > 0.25, -1.0, 1.0)
    for values, label, colour, dash in (
        (s, "s", BLUE, "-"),
        (back * ds / np.abs(ds).max(), "ds/dt, normalised", ORANGE, "--"),
        (dds / np.abs(dds).max(), "d²s/dt², normalised", GREEN, ":"),
    ):
        axes[0].plot(1e3 * cycle, values, dash, color=colour, label=label)
    axes[0].set(title="(a) 4-5-6-7 polynomial", ylabel="[–]")
    axes[0].set_ylim(-1.1, 2.2)
    axes[0].legend(fontsize=7, loc="upper center")
    for ax, name, letter in zip(axes[1:], ("rotation", "translation", "helical"), "bcd"):
        psi, _, _ = motion.c_drive_motion(name, 2.0).sample(cycle)
        u, theta = c_drive.collar_pose(psi, CDriveParameters().lead).T
        ax.plot(1e3 * cycle, 1e3 * u, color=BLUE)
        twin = ax.twinx()
        twin.plot(1e3 * cycle, theta, "--", color=ORANGE)
        ax.set_ylim(-210.0, 210.0)
        twin.set_ylim(-3.3, 3.3)
        twin.grid(False)
        twin.spines["right"].set_visible(True)
        ax.set_ylabel("u [mm]", color=BLUE)
        twin.set_ylabel("θ [rad]", color=ORANGE)
        ax.set_title(f"({letter}) {name}")
    for ax in axes:
        ax.set_xlabel("time [ms]")
    return figure


def helical_errors(rows: Sequence[ComparedRow]) -> Figure:
    """Fig. 5-1 e-f: how the three controllers' errors compare in helical motion."""
    figure, axes = plt.subplots(1, 2, figsize=(11.0, 3.8), sharex=True)
    for name in benchmark.SETTINGS:
        run = _run(name, "helical")
        cycle = slice(0, Conditions().samples_per_cycle)
        for ax, column, scale, metric in (
            (axes[0], 1, 1.0, thesis_tables.E_THETA_RMS),
            (axes[1], 0, 1e3, thesis_tables.E_U_RMS),
        ):
            row = _find(rows, name, "helical", metric)
            ax.plot(
                1e3 * run.time[cycle],
                scale * run.error[cycle, column],
                color=COLOURS[name],
                label=f"{LABELS[name]}: {_numbers(row)}",
            )
    axes[0].set(title="(e) rotation error, helical motion", ylabel="eθ [rad]")
    axes[1].set(title="(f) translation error, helical motion", ylabel="e_u [mm]")
    for ax in axes:
        ax.set_xlabel("time [ms]")
        _legend(ax)
    return figure


def selected_tests(rows: Sequence[ComparedRow]) -> Figure:
    """Fig. 5-2: PD in rotation, CT in translation and TS in helical motion, our two simulations."""
    figure, axes = plt.subplots(2, 3, figsize=(11.0, 5.2), sharex=True)
    panels = (
        ("pd", "rotation", ("torque", 1), "(a) PD, rotation: right motor torque"),
        ("ct", "translation", ("torque", 1), "(c) CT, translation: right motor torque"),
        ("ts", "helical", ("error", 1), "(e) TS, helical: rotation error"),
        ("pd", "rotation", ("error", 1), "(b) PD, rotation: rotation error"),
        ("ct", "translation", ("error", 0), "(d) CT, translation: translation error"),
        ("ts", "helical", ("error", 0), "(f) TS, helical: translation error"),
    )
    for ax, (name, motion_name, (kind, column), title) in zip(axes.flat, panels):
        metric, unit = {
            ("torque", 1): (thesis_tables.TAU_RMS, "τ_R [N m]"),
            ("error", 0): (thesis_tables.E_U_RMS, "e_u [mm]"),
            ("error", 1): (thesis_tables.E_THETA_RMS, "eθ [rad]"),
        }[kind, column]
        scale = 1e3 if (kind, column) == ("error", 0) else 1.0
        for sampled, colour, label in ((False, COLOURS[name], "ours"), (True, PURPLE, "sampled")):
            run = _run(name, motion_name, sampled)
            cycle = slice(0, Conditions().samples_per_cycle)
            values = (run.torque if kind == "torque" else run.error)[cycle, column]
            ax.plot(
                1e3 * run.time[cycle],
                scale * values,
                "--" if sampled else "-",
                color=colour,
                linewidth=1.0 if sampled else 1.4,
                label=label,
            )
        row = _find(rows, name, motion_name, metric)
        ax.set_title(title)
        ax.set_ylabel(unit)
        ax.set_xlabel(f"time [ms]\nRMS: {_numbers(row)}", fontsize=8)
        ax.legend(fontsize=7, loc="upper right", ncols=2)
        low, high = ax.get_ylim()
        ax.set_ylim(low, high + 0.18 * (high - low))
    return figure


def reproduction(rows: Sequence[ComparedRow]) -> Figure:
    """How far our two simulations are from the printed one, for every printed RMS."""
    chosen = [row for row in rows if row.metric in UNITS and row.thesis_sim]
    figure, axes = plt.subplots(1, 3, figsize=(11.0, 3.4), sharex=True)
    for ax, (metric, quantity) in zip(axes, UNITS.items()):
        group = [row for row in chosen if row.metric == metric][::-1]
        y = np.arange(len(group))
        printed = np.array([row.thesis_sim for row in group], dtype=float)
        ax.barh(
            y,
            200.0 * thesis_tables.HALF_PRINT / printed,
            left=-100.0 * thesis_tables.HALF_PRINT / printed,
            height=0.8,
            color=ink(),
            alpha=0.15,
            label="rounding of the print",
        )
        sampled = np.array([row.ours_sampled for row in group])
        ours = np.array([row.ours for row in group])
        ax.plot(100 * (sampled / printed - 1), y, "s", color=ORANGE, label="sampled, model +5 %")
        ax.plot(100 * (ours / printed - 1), y, "o", color=BLUE, label="ours: blocks, model −5 %")
        ax.axvline(0.0, color=ink(), linewidth=0.8)
        ax.set_yticks(y, [f"{LABELS[row.controller]} {row.motion}" for row in group])
        ax.set_title(f"{quantity}, RMS")
        ax.set_xlabel("deviation from the printed\nsimulation [%]")
    axes[0].legend(fontsize=7, loc="lower left")
    return figure


@cache
def _run(name: str, motion_name: str, sampled: bool = False) -> BenchmarkRun:
    parameters = CDriveParameters()
    plant = c_drive.drive(parameters)
    if sampled:
        held = benchmark.sampled_controllers(parameters)[name]
        return benchmark.benchmark_run(plant, held, motion_name, Conditions())
    blocks = benchmark.thesis_controllers(parameters, model_factor=MODEL_FACTOR)[name]
    return benchmark.benchmark_run(plant, blocks, motion_name, Conditions())


def _find(rows: Sequence[ComparedRow], name: str, motion_name: str, metric: str) -> ComparedRow:
    return next(
        row
        for row in rows
        if (row.controller, row.motion, row.metric) == (name, motion_name, metric)
    )


def _numbers(row: ComparedRow) -> str:
    return f"ours {row.ours:.4f}, thesis sim {row.thesis_sim:.4f}, exp {row.thesis_exp:.4f}"


def _legend(ax: Axes) -> None:
    ax.legend(fontsize=8, loc="upper left", bbox_to_anchor=(0.0, -0.2), title="RMS")
