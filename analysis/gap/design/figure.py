"""Figure of a design: the motion with its limits, and the expected difference beside the noise."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from ...figures import BLUE, VERMILION
from .experiment import Design
from .limits import drive_of

STYLES = ((BLUE, "-"), (VERMILION, "--"))


def plot_design(design: Design, path: Path) -> None:
    """Task motion, speed, effort and prediction errors of the refitted rival over time, as PNG."""
    machine, limits = drive_of(design.diagnosis.machine), design.limits
    figure = Figure(figsize=(8.0, 9.0), layout="constrained")
    axes = figure.subplots(4, 1, sharex=True)
    t = design.motion.times(design.responses[0].run.dt)
    position, rate, _ = design.motion.sample(t)
    task = position @ machine.task_map.T
    for i, (name, (color, style)) in enumerate(zip(machine.task, STYLES)):
        span = max(limits.upper[i], -limits.lower[i], 1e-12)
        axes[0].plot(t, task[:, i] / span, style, color=color, label=name)
        for bound in (limits.lower[i], limits.upper[i]):
            axes[0].axhline(bound / span, color=color, linestyle=":", linewidth=0.8)
    for j, (name, (color, style)) in enumerate(zip(machine.joints, STYLES)):
        axes[1].plot(t, rate[:, j], style, color=color, label=name)
        command = design.responses[0].run.command[:, j]
        axes[2].plot(t, command, style, color=color, linewidth=0.8, label=name)
    for ax, bound in ((axes[1], limits.speed), (axes[2], limits.effort)):
        for side in (-bound, bound):
            ax.axhline(side, color="0.4", linestyle=":", linewidth=0.8)
    labels = ["+".join(r.fit.hypothesis.ids) for r in (design.pair.first, design.pair.second)]
    for response, label, (color, style) in zip(design.responses, labels, STYLES):
        size = np.sqrt(np.mean(response.difference**2, axis=1))
        axes[3].plot(t, size, style, color=color, linewidth=0.8, label=f"if {label} is true")
    axes[3].axhline(design.noise, color="0.4", linestyle=":", label="noise, rms")
    unit = machine.position_unit
    axes[0].set_ylabel("task position over\nits farther limit [-]")
    axes[1].set_ylabel(f"shaft speed [{unit}/s]")
    axes[2].set_ylabel(f"command [{machine.effort_unit}]")
    axes[3].set_ylabel(f"error of the refitted\nrival [{unit}]")
    axes[3].set_xlabel("time [s]")
    for ax in axes:
        ax.grid(alpha=0.3)
        ax.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize="small")
    figure.suptitle(
        f"{labels[0]} against {labels[1]}: {design.nats:.3g} nats a run expected, "
        f"{design.runs} run{'s' if design.runs > 1 else ''} for {100 * design.error:g} % error\n"
        "dotted: limits and noise",
        fontsize="medium",
    )
    figure.savefig(path, dpi=110)
