"""Figure of one C-drive run: does the collar follow, and what torque does it take?"""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from ..models.c_drive import collar_pose
from .figures import BLUE, VERMILION

DECIMALS = 12  # of m and rad: rounding errors of an axis at rest are not drawn

if TYPE_CHECKING:
    from .simulation import CDriveRun


def plot_run(run: "CDriveRun", path: Path) -> None:
    """Reference and errors of the collar and the delivered torques over time, as PNG."""
    figure = Figure(figsize=(8.0, 8.0), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True)
    pose = np.round(collar_pose(run.reference, run.config.machine.lead), DECIMALS)
    errors = np.round(run.collar_errors(), DECIMALS)
    rotation = axes[0].twinx()
    lines = [
        *axes[0].plot(run.t, 1e3 * pose[:, 0], color=BLUE, label="translation"),
        *rotation.plot(run.t, pose[:, 1], color=VERMILION, linestyle="--", label="rotation"),
    ]
    axes[0].set_ylabel("reference u [mm]")
    rotation.set_ylabel("reference θ [rad]")
    axes[0].legend(handles=lines, loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
    axes[1].plot(run.t, 1e3 * errors[:, 0], color=BLUE, linewidth=0.8)
    axes[1].set_ylabel("error of u [mm]")
    axes[2].plot(run.t, 1e3 * errors[:, 1], color=VERMILION, linewidth=0.8)
    axes[2].set_ylabel("error of θ [mrad]")
    for side, color, style, name in ((0, BLUE, "-", "left"), (1, VERMILION, "--", "right")):
        axes[3].plot(run.t, run.torque[:, side], style, color=color, linewidth=0.8, label=name)
    axes[3].set_ylabel("motor torque [N m]")
    axes[3].set_xlabel("time [s]")
    axes[3].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
    for row, unit, factor, column in ((1, "mm", 1e3, 0), (2, "mrad", 1e3, 1)):
        rms = factor * np.sqrt(np.mean(errors[:, column] ** 2))
        axes[row].set_title(f"RMS {rms:.3g} {unit}", loc="right", fontsize="small")
    for ax in axes:
        ax.grid(alpha=0.3)
    c = run.config
    figure.suptitle(
        f"C-drive: {type(c.controller).__name__}, {c.program().name} at {c.program().rate:g} Hz, errors by encoder"
    )
    figure.savefig(path, dpi=120)
