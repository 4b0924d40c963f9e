"""The picture: does what explains the 2 Hz experiment explain the 1 Hz one?"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ....models.thesis_tables import CONTROLLERS, E_THETA_RMS, E_U_RMS, MOTIONS, TAU_RMS
from ...figures import BLUE, VERMILION, ink

if TYPE_CHECKING:
    from .result import Entry

LABELS = {
    TAU_RMS: "RMS torque [N m]",
    E_U_RMS: "RMS translation error [mm]",
    E_THETA_RMS: "RMS rotation error [rad]",
}
TITLES = {2.0: "2 Hz, fitted (Table 5-4)", 1.0: "1 Hz, held out (Table 5-9)"}
SMALLEST = 1e-4  # drawn; the last printed decimal


def measured_and_models(entries: Sequence[Entry], best: str) -> Figure:
    """Every printed value of the experiment beside the nominal model and the best hypothesis."""
    figure, axes = plt.subplots(3, 2, figsize=(11.0, 8.2), sharex=True, sharey="row")
    tests = [(controller, motion) for motion in MOTIONS for controller in CONTROLLERS]
    for row, metric in zip(axes, LABELS):
        for ax, rate in zip(row, TITLES):
            found = {
                (e.controller, e.motion): e
                for e in entries
                if e.metric == metric and e.rate_Hz == rate
            }
            _panel(ax, [found[test] for test in tests], best)
            if metric == TAU_RMS:
                ax.set_title(TITLES[rate])
                ax.set_ylim(bottom=0.0)
            else:
                ax.set_yscale("log")
        row[0].set_ylabel(LABELS[metric])
    for ax in axes[-1]:
        labels = [f"{c.upper()}\n{m}" if c == "ct" else c.upper() for c, m in tests]
        ax.set_xticks(range(len(tests)), labels)
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3)
    return figure


def _panel(ax: Axes, entries: Sequence[Entry], best: str) -> None:
    x = np.arange(len(entries))
    measured = np.array([e.measured for e in entries])
    deviation = np.array([e.deviation for e in entries])
    low = np.minimum(deviation, measured - SMALLEST)
    ax.errorbar(
        x, measured, np.vstack([np.maximum(low, 0.0), deviation]), fmt="_", color=ink(),
        markersize=14, capsize=3, label="printed experiment, ± one standard deviation",
    )  # fmt: skip
    for name, colour, mark, shift in (
        ("nominal", BLUE, "s", -0.18),
        ("best", VERMILION, "o", 0.18),
    ):
        values = np.maximum([getattr(e, name) for e in entries], SMALLEST)
        label = "nominal simulation" if name == "nominal" else best
        ax.plot(x + shift, values, mark, color=colour, markersize=5, label=label)
    for edge in (2.5, 5.5):
        ax.axvline(edge, color=ink(), linewidth=0.5, alpha=0.4)
