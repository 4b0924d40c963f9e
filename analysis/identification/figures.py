"""Figures of an identification: where the motion goes, what is known of each parameter, and the held-out forces."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ..figures import BLUE, ORANGE, SKY, VERMILION
from .base import words
from .study import Study

Axes = Any
Floats = NDArray[np.float64]
Writer = Callable[[Path], Any]


def writers(study: Study) -> dict[str, Writer]:
    """File names and what writes them."""
    drawn = {"excitation.png": excitation, "parameters.png": parameters, "validation.png": forces}
    return {name: _saver(draw(study)) for name, draw in drawn.items()}


def excitation(study: Study) -> Figure:
    """Does the motion use the joint space and the limits?"""
    m, best = study.machine, study.best
    figure = Figure(figsize=(10.0, 4.6), layout="constrained")
    plane, rates = figure.subplots(1, 2)
    t = np.linspace(0.0, best.excitation.motion.period, 1200)
    q, v, _ = best.excitation.sample(t)
    unit, factor = ("deg", 180.0 / np.pi) if m.unit == "rad" else ("mm", 1e3)
    if m.axes > 1:
        _joint_space(plane, study, factor)
        shown, name, title = factor * q, f"axis 2 [{unit}]", "joint space"
    else:  # one axis: what the motion sees of its positions and speeds
        shown, name, title = factor * np.hstack([q, v]), f"speed [{unit}/s]", "phase plane"
    plane.plot(shown[:, 0], shown[:, 1], color=VERMILION, lw=1.2, label="motion")
    plane.plot(shown[0, 0], shown[0, 1], "o", color=VERMILION, label="start")
    plane.set(xlabel=f"axis 1 [{unit}]", ylabel=name, title=title)
    plane.legend(loc="best", fontsize=8)
    for axis, colour in zip(range(m.axes), (BLUE, ORANGE, VERMILION)):
        rates.plot(t, factor * v[:, axis], color=colour, lw=1.2, label=f"axis {axis + 1}")
    for sign in (-1.0, 1.0):
        rates.axhline(sign * factor * m.speed[0], color="0.5", lw=0.8, ls="--")
    rates.set(xlabel="time [s]", ylabel=f"speed [{unit}/s]", title="speed, dashed: limit")
    rates.legend(loc="upper right", fontsize=8)
    figure.suptitle(f"{m.title}: condition number {best.condition:.2f} ({best.method} search)")
    return figure


def parameters(study: Study) -> Figure:
    """Do the intervals of the base parameters hold what was planted, and how wide are they?"""
    planted, half = study.base.combination @ study.truth, study.fitted.half_width
    off = (study.fitted.values - planted) / half
    figure = Figure(figsize=(8.5, 1.2 + 0.4 * len(planted)), layout="constrained")
    axes = figure.subplots()
    rows = np.arange(len(planted))[::-1]
    axes.axvline(0.0, color="0.5", lw=0.8)
    axes.errorbar(off, rows, xerr=1.0, fmt="o", color=BLUE, capsize=3)
    labels = [_short(line) for line in words(study.base, study.machine.names)]
    axes.set_yticks(rows, labels, fontsize=7)
    widths = axes.secondary_yaxis("right")
    widths.set_yticks(rows, [_width(h, p) for h, p in zip(half, planted)], fontsize=7)
    reach = max(3.0, 0.3 + float(np.abs(off).max()) + 1.0)
    axes.set(
        xlabel="estimate less planted value, in half-widths of its interval", xlim=(-reach, reach)
    )
    axes.set_title(
        f"{study.machine.title}: base parameters, 95 % intervals (right: their half-width, of planted or in SI units)",
        fontsize=10,
    )
    return figure


def forces(study: Study) -> Figure:
    """Do the identified parameters predict the forces of another motion?"""
    data, m = study.validation, study.machine
    predicted = data.regressor @ study.feasible
    theory = data.regressor @ np.concatenate([m.prior, np.zeros(2 * m.axes)])
    figure = Figure(figsize=(9.5, 2.3 * m.axes), layout="constrained")
    unit = "N" if m.unit == "m" else "N m"
    for i, axes in enumerate(np.atleast_1d(figure.subplots(m.axes, 1, sharex=True))):
        own = data.axis == i
        t, without, measured, found = _broken(
            data.time[own], theory[own], data.force[own], predicted[own]
        )
        axes.plot(t, without, color=SKY, lw=1.0, label="theoretical, no friction")
        axes.plot(t, measured, color="0.3", lw=1.6, label="measured (simulated)")
        axes.plot(t, found, color=VERMILION, lw=1.0, ls="--", label="identified, feasible")
        axes.set_ylabel(f"axis {i + 1} [{unit}]")
    axes.set_xlabel("time [s]")
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8
    )
    errors = study.errors
    figure.suptitle(
        f"{m.title}, another motion: force error {1e2 * errors['feasible']:.1f} % "
        f"({1e2 * errors['theoretical, no friction']:.0f} % before)",
        x=0.01,
        ha="left",
        fontsize=10,
    )
    return figure


def _broken(t: Floats, *signals: Floats) -> list[Floats]:
    """Times and signals with NaN where rows at rest are left out, so that no line leads across."""
    steps = np.diff(t)
    gaps = 1 + np.flatnonzero(steps > 1.5 * np.median(steps))
    return [np.insert(signal, gaps, np.nan) for signal in (t, *signals)]


def _joint_space(axes: Axes, study: Study, factor: float) -> None:
    m = study.machine
    low, high = factor * m.lower[:2], factor * m.upper[:2]
    box = np.array([low, (high[0], low[1]), high, (low[0], high[1]), low])
    axes.plot(*box.T, color="0.5", lw=0.8, ls="--", label="travel")
    if m.polygon is not None:
        ring = factor * np.vstack([m.polygon, m.polygon[:1]])
        axes.plot(*ring.T, color=BLUE, lw=1.2, label="joint space")


def _width(half: float, planted: float) -> str:
    """Half-width as a share of the planted value, or as it is where nothing was planted."""
    if not planted:
        return f"± {half:.1g}"
    share = half / abs(planted)
    return f"± {1e2 * share:.2g} %" if share < 0.995 else f"± {share:.3g} times"


def _short(line: str, limit: int = 52) -> str:
    return line if len(line) <= limit else f"{line[: limit - 4]} ..."


def _saver(figure: Figure) -> Writer:
    return lambda path: figure.savefig(path, format="png", dpi=130)
