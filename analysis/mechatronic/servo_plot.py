"""Figure of one servo run: does the platform follow, and what torque does it take?"""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..figures import BLUE, GREEN, ORANGE, VERMILION, plt, style
from .servo_machines import ServoMachine

if TYPE_CHECKING:
    from .servo_run import ServoRun

LINES = ((BLUE, "-"), (VERMILION, "--"), (GREEN, ":"))


def plot(machine: ServoMachine, run: "ServoRun", path: Path) -> None:
    """Path or pose of the platform; errors of task and joints, and torques of the motors, over time; as PNG."""
    with style():
        figure = plt.figure(figsize=(9.0, 7.0))
        grid = figure.add_gridspec(3, 2, width_ratios=(1.1, 1.0))
        left = figure.add_subplot(grid[:, 0])
        (_plane if run.planar else _pose)(left, run)
        axis, joints = run.loop.axis, run.loop.machine.joints
        turns = (run.joint_reference - run.joint_position) / axis.per_motor / (2.0 * np.pi)
        rows = (
            _task_error(run),
            ("joint error [motor turns]", turns, joints),
            ("motor torque [N m]", axis.torque_constant * run.current, joints),
        )
        for i, (label, values, names) in enumerate(rows):
            ax = figure.add_subplot(grid[i, 1])
            for column, (colour, dash), name in zip(values.T, LINES, names):
                ax.plot(run.t, column, dash, color=colour, linewidth=1.0, label=name)
            ax.set_ylabel(label)
            if len(names) > 1 and i < 2:
                ax.legend(loc="upper right")
        ax.set_xlabel("time [s]")
        figure.suptitle(
            f"{machine.title} under {run.loop.scheme} control, machine as {run.loop.coupling}",
            fontsize=11,
        )
        figure.savefig(path, dpi=120)
        plt.close(figure)


def _task_error(run: "ServoRun") -> tuple[str, Any, tuple[str, ...]]:
    if run.planar:
        return "off the path [mm]", 1e3 * run.off_path()[:, None], ("tool",)
    return (
        "task error [mm, mrad]",
        1e3 * (run.reference - run.position),
        run.loop.machine.task,
    )


def _plane(axes: Any, run: "ServoRun") -> None:
    axes.plot(*run.reference.T, color=ORANGE, linewidth=3.0, alpha=0.6, label="commanded")
    axes.plot(*run.position.T, color=BLUE, label="simulated")
    axes.set(xlabel="x [m]", ylabel="y [m]")
    axes.set_aspect("equal", adjustable="datalim")
    axes.legend(loc="upper right")
    off = run.numbers()["path_deviation_mm"]
    axes.set_title(f"{run.name}: off the path by up to {off:.2g} mm")


def _pose(axes: Any, run: "ServoRun") -> None:
    """Task coordinates from where they start, over time."""
    from .servo_run import milli

    for i, name in enumerate(run.loop.machine.task):
        colour, dash = LINES[i]
        asked, got = (1e3 * (x[:, i] - run.reference[0, i]) for x in (run.reference, run.position))
        axes.plot(run.t, asked, color=ORANGE, linewidth=3.0, alpha=0.6)
        axes.plot(run.t, got, dash, color=colour, label=f"{name} [{milli(name)}]")
    axes.plot([], [], color=ORANGE, linewidth=3.0, alpha=0.6, label="commanded")
    axes.set(xlabel="time [s]", ylabel="task coordinates, from the start [mm, mrad]")
    axes.legend(loc="upper right")
    axes.set_title(run.name)
