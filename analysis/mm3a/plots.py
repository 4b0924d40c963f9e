"""Figures of the MM3A, with the angles of the thesis; data in, figure out."""

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from ...models.mm3a.arm import Arm
from ..files import write_whole
from .experiments import empirical_truth
from .runs import groups, mean_of_inverse

if TYPE_CHECKING:
    from .calibration import Calibration
    from .positioning import ErrorGrowth
    from .prediction import Comparison

# Okabe and Ito 2008, distinguishable to the colour-blind.
BLUE, ORANGE, GREEN, PURPLE, SKY, VERMILION = (
    "#0072B2",
    "#E69F00",
    "#009E73",
    "#CC79A7",
    "#56B4E9",
    "#D55E00",
)
JOINT_COLOURS = {1: GREEN, 2: BLUE, 3: VERMILION}
BELOW = (0.5, -0.14)  # a legend under its axes, in their coordinates
DIRECTIONS = {-1: ("v", "negative"), 1: ("^", "positive")}


def figure(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (7.0, 4.2)
) -> tuple[Figure, Any]:
    """Figure without global state, and its axes."""
    canvas = Figure(figsize=size, layout="constrained")
    axes = canvas.subplots(rows, columns, squeeze=False)
    for ax in axes.ravel():
        ax.grid(True, alpha=0.3)
    return canvas, axes


def save(canvas: Figure, path: Path) -> None:
    """Write a figure as PNG, whole or not at all."""
    data = io.BytesIO()
    with matplotlib.rc_context({"font.size": 10}):
        canvas.savefig(data, format="png", dpi=150)
    write_whole(path, data.getvalue())


def calibration(result: "Calibration") -> Figure:
    """How far is each measured mean step from the calibrated model?"""
    canvas, axes = figure()
    ax = axes[0, 0]
    position = 0
    for (joint, direction), estimate in result.likelihood.items():
        marker, word = DIRECTIONS[direction]
        errors = _residuals(result, joint, direction)
        ax.plot(
            position + np.arange(len(errors)),
            100.0 * errors,
            marker,
            color=JOINT_COLOURS[joint],
            fillstyle="full" if direction > 0 else "none",
            markersize=5,
            label=f"joint {joint}, {word}: scatter {100 * estimate.scatter:.2f} %",
        )
        position += len(errors) + 2
    ax.axhline(0.0, color="black", linewidth=0.8)
    ax.set_xlabel("run, in the order of the table within each joint and direction")
    ax.set_ylabel("measured over calibrated mean step, less 1 [%]")
    ax.set_title("Does the calibrated model explain every run?")
    ax.legend(fontsize=8, ncols=3, loc="upper center", bbox_to_anchor=BELOW)
    return canvas


def _residuals(result: "Calibration", joint: int, direction: int) -> Any:
    estimate = result.likelihood[joint, direction]
    sizes = empirical_truth(result.model(), Arm())
    factors = {day: factor for day, (factor, _) in estimate.days.items()}
    return np.array(
        [
            run.mean_step / (mean_of_inverse(sizes(run)) * factors.get(run.day, 1.0)) - 1.0
            for run in groups(result.runs)[joint, direction]
        ]
    )


MODEL_STYLES = {
    "likelihood": (BLUE, "o"),
    "routine": (SKY, "s"),
    "constant": (ORANGE, "^"),
    "none": (VERMILION, "v"),
    "likelihood, differential": (GREEN, "D"),
}
PREDICTION_AXES = {2: "middle of the interval, ζ = −q₂ [deg]", 3: "elbow angle q₂ [deg]"}


def prediction(result: "Comparison") -> Figure:
    """Does the load model predict better than a constant step, in each direction of joints 2 and 3?"""
    canvas, axes = figure(2, 2, (10.0, 7.0))
    for ax, part in zip(axes.ravel(), result.predictions):
        angles = np.degrees(
            [-0.5 * (r.q2 + r.target) if part.joint == 2 else r.q2 for r in part.runs]
        )
        for name in ("likelihood", "constant"):
            colour, marker = MODEL_STYLES[name]
            ax.plot(
                angles,
                100.0 * part.errors[name],
                marker,
                color=colour,
                markersize=4,
                alpha=0.7,
                label=f"{name}: rms {100 * part.rms(name):.1f} %, worst {100 * part.worst(name):.1f} %",
            )
        ax.axhline(0.0, color="black", linewidth=0.8)
        ax.set_title(f"joint {part.joint}, {DIRECTIONS[part.direction][1]} direction")
        ax.set_xlabel(PREDICTION_AXES[part.joint])
        ax.set_ylabel("predicted over measured step, less 1 [%]")
        ax.legend(fontsize=8, ncols=2, loc="upper center", bbox_to_anchor=BELOW)
    return canvas


def positioning(result: "ErrorGrowth") -> Figure:
    """How does the tip error of an open-loop move grow with its length?"""
    canvas, axes = figure()
    ax = axes[0, 0]
    for name in result.errors:
        colour, marker = MODEL_STYLES[name]
        ax.loglog(
            1e3 * np.array(result.distances),
            1e6 * result.rms(name),
            marker + "-",
            color=colour,
            label=name if "differential" in name else f"{name}, re-planned",
        )
    ax.set_xlabel("length of the move [mm]")
    ax.set_ylabel("tip error, rms over directions [µm]")
    ax.set_title("How does the open-loop error grow with distance?")
    ax.legend(fontsize=8)
    return canvas
