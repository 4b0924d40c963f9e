"""Figure of one five-bar run: does the tool stay on its path, and what torque does it take?"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ..figures import BLUE, ORANGE, VERMILION, plt, style

if TYPE_CHECKING:
    from .five_bar_run import FiveBarRun


def plot(run: "FiveBarRun", path: Path) -> None:
    """Path of the tool, distance from it, errors and torques of the motors over time, as PNG."""
    with style():
        figure = plt.figure(figsize=(9.0, 7.0))
        grid = figure.add_gridspec(3, 2, width_ratios=(1.1, 1.0))
        plane = figure.add_subplot(grid[:, 0])
        plane.plot(*run.reference.T, color=ORANGE, linewidth=3.0, alpha=0.6, label="commanded")
        plane.plot(*run.position.T, color=BLUE, label="simulated")
        plane.set_xlabel("x [m]")
        plane.set_ylabel("y [m]")
        plane.set_aspect("equal", adjustable="datalim")
        plane.legend(loc="upper right")
        numbers = run.numbers()
        plane.set_title(f"{run.name}: off the path by up to {numbers['path_deviation_mm']:.1f} mm")
        axis = run.loop.axis
        turns = (run.joint_reference - run.joint_position) / axis.per_motor / (2.0 * np.pi)
        rows = (
            ("off the path [mm]", 1e3 * run.off_path()[:, None]),
            ("joint error [motor turns]", turns),
            ("motor torque [N m]", axis.torque_constant * run.current),
        )
        for i, (label, values) in enumerate(rows):
            ax = figure.add_subplot(grid[i, 1])
            colours = ((BLUE, "-", "crank 1"), (VERMILION, "--", "crank 4"))
            for column, (colour, dash, name) in zip(values.T, colours):
                ax.plot(run.t, column, dash, color=colour, linewidth=1.0, label=name)
            ax.set_ylabel(label)
            if i == 1:
                ax.legend(loc="upper right")
        ax.set_xlabel("time [s]")
        figure.suptitle(
            f"Five-bar under {run.loop.scheme} control, machine as {run.loop.coupling}", fontsize=11
        )
        figure.savefig(path, dpi=120)
        plt.close(figure)
