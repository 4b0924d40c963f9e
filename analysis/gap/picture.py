"""One picture of a diagnosis: how far does the unexplained effort shrink on runs it never saw?"""

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .result import Diagnosis

BLUE, GREEN, GREY, BLACK = "#0072B2", "#009E73", "#999999", "#333333"  # Okabe-Ito


def shrinkage_picture(diagnosis: Diagnosis) -> Any:
    """Matplotlib figure: rms unexplained effort before, retuned, after, with intervals, and the floor."""
    s = diagnosis.shrinkage
    bars = [("nominal model", "before"), ("retuned in tolerance", "retuned")]
    accepted = diagnosis.verdict.accepted
    if accepted is not None:
        bars.append((" + ".join(accepted.fit.hypothesis.ids), "after"))
    bars.reverse()
    figure = Figure(figsize=(8.0, 2.8), layout="constrained")
    axes = figure.subplots()
    values = [getattr(s, level) for _, level in bars]
    errors = np.abs(np.transpose([s.intervals[level] or (v, v) for (_, level), v in zip(bars, values)])
                    - values)  # fmt: skip
    colours = [GREEN if level == "after" else GREY for _, level in bars]
    drawn = axes.barh([name for name, _ in bars], values, color=colours, height=0.6,
                      xerr=errors, ecolor=BLACK, capsize=3)  # fmt: skip
    axes.bar_label(drawn, fmt="%.3g", padding=4)
    axes.axvline(s.floor, color=BLUE, linestyle="--", label=f"floor {s.floor:.2g}")
    axes.margins(x=0.12)
    axes.set_xlabel(f"unexplained effort on held-out data, rms [{diagnosis.machine.effort_unit}]")
    removed = "" if s.percent is None else f", {s.percent:.0f} % of the gap removed"
    axes.set_title(f"{diagnosis.logset.name}: {diagnosis.verdict.verdict}{removed}", loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower right")
    return figure
