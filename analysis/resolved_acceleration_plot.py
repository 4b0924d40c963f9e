"""Figures of the resolved-acceleration study."""

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from matplotlib.figure import Figure

from .figures import BLUE, GREEN, PURPLE, VERMILION

if TYPE_CHECKING:
    from .resolved_acceleration import StabilityMap, TunedGain


def plot_map(result: "StabilityMap", path: Path) -> None:
    """Which pairs of gains are stable, and where do those of the thesis lie?"""
    from .resolved_acceleration import RATIO, TUNED

    figure = Figure(figsize=(6.5, 5.5), layout="constrained")
    axes = figure.subplots()
    t, r = 1e-3 * result.kp_translation, 1e-3 * result.kp_rotation
    reach = float(np.abs(result.growth).max())
    mesh = axes.pcolormesh(
        t, r, result.growth, cmap="PuOr_r", vmin=-reach, vmax=reach, shading="gouraud"
    )
    axes.contour(t, r, result.growth, levels=[0.0], colors="black", linewidths=1.5)
    figure.colorbar(mesh, ax=axes, label="growth of the least damped mode [1/s]")
    kp = 1e-3 * TUNED.kp
    axes.plot(t, t, color="black", linestyle=":", label="equal gains: computed torque")
    axes.plot(kp, kp, "o", color=GREEN, markeredgecolor="black", label="printed, Table 5-1")
    axes.plot(
        kp,
        RATIO * kp,
        "s",
        color=PURPLE,
        markeredgecolor="black",
        label="rotation 2.5 times, as in TS",
    )
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="translation gain [10³ s⁻²]",
        ylabel="rotation gain [10³ s⁻²]",
        title="Stable inside the black line; torque path as printed",
    )
    axes.title.set_fontsize("medium")
    ticks = [10, 20, 35, 50, 100]
    for axis in (axes.xaxis, axes.yaxis):
        axis.set_ticks(ticks, labels=[str(tick) for tick in ticks])
        axis.set_ticks([], minor=True)
    axes.legend(loc="lower left", fontsize="small")
    figure.savefig(path, dpi=120)


def plot_limits(limits: "dict[str, list[TunedGain]]", path: Path) -> None:
    """How far below the limit of stability are the printed gains, for each torque path?"""
    figure = Figure(figsize=(7.5, 4.0), layout="constrained")
    axes = figure.subplots()
    paths = list(limits)
    names = [gain.name for gain in limits[paths[0]]]
    for i, (name, color, marker) in enumerate(
        zip(names, (BLUE, GREEN, PURPLE, VERMILION), ("o", "s", "^", "D"))
    ):
        shares = [limits[path][i].share for path in paths]
        axes.plot(range(len(paths)), shares, marker, color=color, label=name, markersize=8)
    axes.axhline(1.0, color="black", linewidth=1.5)
    axes.annotate("limit of stability", (0, 1.0), xytext=(0, 4), textcoords="offset points")
    axes.set_xticks(range(len(paths)), labels=paths)
    axes.set(
        ylim=(0.0, 1.25),
        ylabel="printed gain / largest stable gain",
        xlabel="torque path behind the command",
        title="How close to the limit are the gains tuned to just below it?",
    )
    axes.grid(axis="y", alpha=0.3)
    axes.legend(loc="lower right", ncols=2)
    figure.savefig(path, dpi=120)
