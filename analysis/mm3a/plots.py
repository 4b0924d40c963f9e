"""Figures of the MM3A, with the angles of the thesis; data in, figure out."""

import io
from pathlib import Path
from typing import TYPE_CHECKING, Any

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from ...models.mm3a import kinematics
from ...models.mm3a.arm import Arm
from ..files import write_whole
from . import routine, trends
from .experiments import empirical_truth
from .runs import groups, mean_of_inverse
from .travel import passes

if TYPE_CHECKING:
    from .calibration import Calibration
    from .positioning import ErrorGrowth
    from .prediction import Comparison
    from .square import Drawing

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
    ax.set_ylabel("measured/calibrated step − 1 [%]")
    ax.set_title("Does the calibrated model explain every run?")
    canvas.legend(loc="outside lower center", ncols=2, fontsize=8)
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
                label=f"{name} model" if name == "likelihood" else f"{name} step",
            )
        ax.axhline(0.0, color="black", linewidth=0.8)
        errors = ", ".join(
            f"{name} {100 * part.rms(name):.1f}/{100 * part.worst(name):.1f} %"
            for name in ("likelihood", "constant")
        )
        ax.set_title(
            f"joint {part.joint}, {DIRECTIONS[part.direction][1]} direction\nrms/worst: {errors}",
            fontsize=10,
        )
        ax.set_xlabel(PREDICTION_AXES[part.joint])
        ax.set_ylabel("predicted/measured step − 1 [%]")
    canvas.legend(*axes[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=2)
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


TILTED, THIRD, QUARTER = -np.pi / 2, -np.pi / 3, -np.pi / 4  # theta of the experiments [rad]
DIRECTION_COLOURS = {-1: BLUE, 1: VERMILION}


def prismatic_steps() -> Figure:
    """How does the step of joint 3 depend on posture? Angles of Figs. 4.8, 4.10, 4.13, 6.2."""
    canvas, axes = figure(2, 2, (10.0, 7.5))
    elbow = np.linspace(-np.pi, 0.0, 25)
    turn = np.linspace(-np.pi / 2, np.pi / 2, 25)
    panels = (
        ("no weight on the joint, θ = −90° (Fig. 4.8)", elbow, TILTED, "elbow angle q₂ [deg]"),
        ("arm level, base turned by ψ (Fig. 4.10)", turn, 0.0, "base tilt ψ [deg]"),
        ("upright base, θ = 0 (Figs. 4.13a, 6.2)", elbow, 0.0, "elbow angle q₂ [deg]"),
        ("θ = −60° (Figs. 4.13b, 6.2)", elbow, THIRD, "elbow angle q₂ [deg]"),
    )
    for ax, (title, angles, theta, label) in zip(axes.ravel(), panels):
        turned = angles is turn
        postures = [(0.0, -np.pi / 2 if turned else a, 0.006) for a in angles]
        tilts = [(theta, a if turned else 0.0) for a in angles]
        for direction in (-1, 1):
            curve = trends.posture_curve(3, direction, np.degrees(angles), postures, tilts)
            _both_models(ax, curve, direction, 1e9)
        ax.set(title=title, xlabel=label, ylabel="step [nm]")
    axes[0, 0].legend(fontsize=8)
    return canvas


def rotary_steps() -> Figure:
    """How does the step of joint 2 depend on posture? Angles of Figs. 5.5, 5.6, 5.7, 6.6, 6.7."""
    canvas, axes = figure(2, 2, (10.0, 7.5))
    zeta = np.linspace(0.0, np.pi, 19)
    panels = (
        ("no weight on the joint, θ = −90°, q₃ = 0 (Fig. 5.5)", TILTED, 0.0),
        ("upright base, arm retracted, q₃ = 0 (Fig. 5.6a-b)", 0.0, 0.0),
        ("upright base, arm extended, q₃ = 12 mm (Fig. 5.6c-d)", 0.0, 0.012),
    )
    for ax, (title, theta, q3) in zip(axes.ravel(), panels):
        postures, tilts = [(0.0, -a, q3) for a in zeta], [(theta, 0.0)] * zeta.size
        for direction in (-1, 1):
            curve = trends.posture_curve(2, direction, np.degrees(zeta), postures, tilts)
            _both_models(ax, curve, direction, 1e6)
        ax.set(title=title, xlabel="ζ = −q₂ [deg]", ylabel="step [µrad]", ylim=(65.0, 130.0))
    extension = np.linspace(0.0, 0.012, 13)
    for direction in (-1, 1):
        curve = trends.posture_curve(
            2,
            direction,
            1e3 * extension,
            [(0.0, -np.pi / 2, q3) for q3 in extension],
            [(TILTED, 0.0)] * extension.size,
        )
        _both_models(axes[1, 1], curve, direction, 1e6)
    axes[1, 1].set(
        title="inertia alone, θ = −90° (Fig. 5.7)",
        xlabel="extension q₃ [mm]",
        ylabel="step [µrad]",
        ylim=(65.0, 130.0),
    )
    axes[0, 0].legend(fontsize=8)
    return canvas


def travel() -> Figure:
    """Does the step of joint 3 change along its travel? Distance over steps, as in Fig. 4.11."""
    canvas, axes = figure(1, 2, (10.0, 4.2))
    for ax, direction, word in zip(axes.ravel(), (1, -1), ("outward", "inward")):
        chosen = [p for p in passes() if p.direction == direction]
        for i, (run, colour) in enumerate(zip(chosen, (BLUE, ORANGE, GREEN)), start=1):
            label = f"reading {i}: {1e6 * run.departure:.0f} µm rms from a line"
            ax.plot(run.steps, 1e3 * run.read, "o-", color=colour, markersize=3, label=label)
        ax.set(title=f"{word}, q₂ = −90°, θ = ψ = 0", xlabel="steps N", ylabel="distance [mm]")
        ax.legend(fontsize=8)
    return canvas


def _both_models(ax: Any, curve: trends.Curve, direction: int, factor: float) -> None:
    colour, (marker, word) = DIRECTION_COLOURS[direction], DIRECTIONS[direction]
    ax.plot(curve.x, factor * curve.steps["empirical"], color=colour, label=f"empirical, {word}")
    ax.plot(
        curve.x,
        factor * curve.steps["physical"],
        marker,
        color=colour,
        fillstyle="none",
        markersize=4,
        label=f"physical, {word}",
    )


def actuator_trends() -> Figure:
    """On what does the step of the physical actuator depend, and where do simpler models part?"""
    canvas, axes = figure(2, 2, (10.0, 7.5))
    colours = (BLUE, VERMILION, GREEN)
    load, inertia = trends.load_curve(), trends.inertia_curve()
    for colour, (name, steps) in zip(colours, load.steps.items()):
        axes[0, 0].plot(load.x, 1e9 * steps, color=colour, label=name)
    axes[0, 0].set(xlabel="load over weight of link 3 [-]", ylabel="step of joint 3 [nm]")
    axes[0, 0].set_title("load along the axis")
    for colour, (name, steps) in zip(colours[1:], inertia.steps.items()):
        axes[0, 1].semilogx(1e6 * inertia.x, 1e6 * steps, color=colour, label=name)
    low, high = trends.inertia_range()
    axes[0, 1].axvspan(1e6 * low, 1e6 * high, color=SKY, alpha=0.4, label="travel of joint 3")
    axes[0, 1].set(xlabel="inertia about joint 2 [kg mm²]", ylabel="step of joint 2 [µrad]")
    axes[0, 1].set_title("inertia: growth, then the phase of the swing")
    volts, frequency = trends.voltage_curve(), trends.frequency_curve()
    for colour, (name, steps) in zip(colours, volts.steps.items()):
        axes[1, 0].plot(volts.x, 1e9 * steps, color=colour, label=f"hysteresis {name}")
    axes[1, 0].set(xlabel="sawtooth amplitude [V]", ylabel="step of joint 3 [nm]")
    axes[1, 0].set_title("voltage")
    axes[1, 1].semilogx(frequency.x, 1e9 * frequency.steps["physical"], color=VERMILION)
    axes[1, 1].axvline(100.0, color="black", linewidth=0.8, label="100 Hz of the thesis")
    axes[1, 1].set(xlabel="steps per second [Hz]", ylabel="step of joint 3 [nm]")
    axes[1, 1].set_title("frequency")
    for ax in axes.ravel():
        ax.legend(fontsize=8)
    return canvas


def load_from_difference() -> Figure:
    """What does equation (6.6) mean? The free parameter d over the difference of mean steps (Fig. 6.5)."""
    canvas, axes = figure()
    ax = axes[0, 0]
    difference = np.linspace(-routine.FIT_RANGE, routine.FIT_RANGE, 41)
    for free, colour in ((75e-6, SKY), (95e-6, BLUE), (115e-6, PURPLE)):
        loads = [routine.load_exactly(free, free + d) for d in difference]
        ax.plot(
            1e6 * difference,
            1e6 * np.array(loads),
            color=colour,
            label=f"exact, free step {1e6 * free:.0f} µrad",
        )
    ax.plot(
        1e6 * difference,
        1e6 * np.polyval(routine.PRINTED, difference),
        "--",
        color=VERMILION,
        label="(6.6), Δ in 0.01 rad and d in rad",
    )
    ax.plot(
        1e6 * difference,
        1e6 * np.polyval((3.41, 0.025, 6.42e-7), difference),
        ":",
        color=ORANGE,
        label="(6.6) read in rad",
    )
    ax.set(
        xlabel="mean step loaded less free, Δ [µrad]",
        ylabel="free parameter d [µrad]",
        title="What does equation (6.6) mean?",
    )
    ax.legend(fontsize=8)
    return canvas


def view(drawing: "Drawing") -> Figure:
    """What does the arm look like, and what do its steps look like at their own scale?"""
    canvas = Figure(figsize=(11.0, 5.0), layout="constrained")
    arm_axes: Any = canvas.add_subplot(1, 2, 1, projection="3d")
    q = drawing.joints["step model"][0]
    points = 1e3 * _joints_of_arm(q)
    arm_axes.plot(*points.T, "o-", color="black", linewidth=3)
    arm_axes.plot(*points[-1:].T, "*", color=VERMILION, markersize=12, label="tip")
    arm_axes.set(xlabel="x₀ [mm]", ylabel="y₀ [mm]", zlabel="z₀ [mm]", title="the arm in frame 0")
    low, high = points.min(axis=0), points.max(axis=0)
    reach = 0.6 * np.max(high - low)
    for setter, centre in zip(
        (arm_axes.set_xlim, arm_axes.set_ylim, arm_axes.set_zlim), 0.5 * (low + high)
    ):
        setter(centre - reach, centre + reach)
    arm_axes.view_init(elev=20.0, azim=-70.0)
    arm_axes.legend(fontsize=8)
    path_axes: Any = canvas.add_subplot(1, 2, 2, projection="3d")
    start = drawing.tips("step model")[0]
    for name, colour in (("constant step", ORANGE), ("step model", BLUE)):
        tips = 1e6 * (drawing.tips(name) - start)
        path_axes.plot(*tips.T, color=colour, linewidth=1.0, label=name)
    wanted = 1e6 * (drawing.wanted - start)
    path_axes.plot(*wanted.T, "--", color="black", linewidth=1.0, label="wanted")
    path_axes.set(
        xlabel="x₀ [µm]", ylabel="y₀ [µm]", zlabel="z₀ [µm]", title="tip path, from its start"
    )
    path_axes.view_init(elev=15.0, azim=-75.0)
    path_axes.legend(fontsize=8)
    return canvas


def _joints_of_arm(q: Any) -> Any:
    """Base, elbow and tip in frame 0 [m], with the puck's axis below."""
    arm = Arm()
    elbow = arm.shoulder * np.array([np.cos(q[0]), np.sin(q[0]), 0.0])
    return np.array([[0.0, 0.0, -0.013], [0.0, 0.0, 0.0], elbow, kinematics.tip(q, arm)])
