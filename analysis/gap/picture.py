"""One picture of a diagnosis: how far does the unexplained effort shrink on runs it never saw?"""

from typing import Any

from matplotlib.figure import Figure

from .diagnosis import Diagnosis

BLUE, GREEN, GREY = "#0072B2", "#009E73", "#999999"  # Okabe-Ito


def shrinkage_picture(diagnosis: Diagnosis) -> Any:
    """Matplotlib figure: rms unexplained effort before, retuned, after, and the floor."""
    s = diagnosis.shrinkage
    bars = [("nominal model", s.before), ("retuned in tolerance", s.retuned)]
    accepted = diagnosis.verdict.accepted
    if accepted is not None:
        bars.append((" + ".join(accepted.fit.hypothesis.ids), s.after))
    figure = Figure(figsize=(8.0, 2.8), layout="constrained")
    axes = figure.subplots()
    names = [name for name, _ in bars][::-1]
    colours = [GREY, GREY, GREEN][: len(bars)][::-1]
    drawn = axes.barh(names, [value for _, value in bars][::-1], color=colours, height=0.6)
    axes.bar_label(drawn, fmt="%.3g", padding=4)
    axes.axvline(s.floor, color=BLUE, linestyle="--", label=f"floor {s.floor:.2g}")
    axes.margins(x=0.12)
    axes.set_xlabel(f"unexplained effort on held-out data, rms [{diagnosis.machine.effort_unit}]")
    removed = "" if s.percent is None else f", {s.percent:.0f} % of the gap removed"
    axes.set_title(f"{diagnosis.logset.name}: {diagnosis.verdict.verdict}{removed}", loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(frameon=False, loc="lower right")
    return figure
