"""Figures of the workspaces: one question a figure."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.figure import Figure

from ..figures import BLUE, GREEN, ORANGE, VERMILION
from .planar import PRINTED_RECTANGLE, Planar
from .tables import DIRECTIONS, Tilts

Writer = Callable[[Path], Any]


def planar(result: Planar) -> Figure:
    """Which joint positions are safe, what does the tool reach, and how well does it move there?"""
    figure = Figure(figsize=(10.5, 4.6), layout="constrained")
    joints, space = figure.subplots(1, 2)
    factor, unit = (180.0 / np.pi, "deg") if result.unit == "rad" else (1e3, "mm")
    ring = factor * np.vstack([result.joint_space, result.joint_space[:1]])
    joints.fill(*ring.T, color=BLUE, alpha=0.2)
    joints.plot(*ring.T, color=BLUE)
    joints.set(xlabel=f"axis 1 [{unit}]", ylabel=f"axis 2 [{unit}]", title="joint space")
    dots = space.scatter(
        *(1e3 * result.tools.T), c=result.dexterity, s=4, cmap="viridis", vmin=0.0, vmax=1.0
    )
    edge = 1e3 * np.vstack([result.boundary, result.boundary[:1]])
    space.plot(*edge.T, color=VERMILION, lw=1.2, label="edge of the joint space")
    if "printed_rectangle" in result.findings:
        left, right, bottom, top = (1e3 * value for value in PRINTED_RECTANGLE)
        x, y = [left, right, right, left, left], [bottom, bottom, top, top, bottom]
        space.plot(x, y, color="k", ls="--", label="printed, of a point below")
    space.set(xlabel="x [mm]", ylabel="y [mm]", title="workspace of the tool", aspect="equal")
    space.legend(fontsize=8, loc="best")
    figure.colorbar(dots, ax=space, label="dexterity (1: same in all directions)")
    figure.suptitle(result.title)
    return figure


def tilts(result: Tilts) -> Figure:
    """How far does the platform tilt at each height?"""
    figure = Figure(figsize=(6.0, 5.0), layout="constrained")
    axes = figure.subplots()
    colours = colormaps["viridis"](np.linspace(0.0, 0.9, len(result.heights)))
    for height, largest, colour in zip(result.heights, result.largest, colours):
        closed = np.append(np.arange(len(DIRECTIONS)), 0)
        psi, theta = (largest * wave(DIRECTIONS) for wave in (np.cos, np.sin))
        axes.plot(
            np.rad2deg(psi)[closed],
            np.rad2deg(theta)[closed],
            color=colour,
            label=f"{1e3 * height:+.0f} mm",
        )
    axes.set(xlabel="psi, about x [deg]", ylabel="theta, about y [deg]", aspect="equal")
    axes.legend(title="z over home", fontsize=8)
    axes.set_title(f"{result.title}: largest tilts")
    return figure


def measured(result: Tilts) -> Figure:
    """How far are the rigid kinematics from the measured platform?"""
    figure = Figure(figsize=(10.0, 3.8), layout="constrained")
    rows = result.findings["measured"]
    places = np.arange(len(rows))
    names = (("z_um", "z [µm]"), ("psi_arcsec", "psi ['']"), ("theta_arcsec", "theta ['']"))
    for axes, (name, label) in zip(figure.subplots(1, 3), names):
        for source, colour, marker, shift in (
            ("cmm", "k", "s", -0.15),
            ("fem", GREEN, "^", -0.05),
            ("printed_fkp", ORANGE, "o", 0.05),
            ("ours", VERMILION, "x", 0.15),
        ):
            values = [row[name][source] for row in rows]
            axes.plot(places + shift, values, marker, color=colour, label=source.replace("_", " "))
        axes.axhline(0.0, color="0.7", lw=0.8)
        axes.set_xticks(places, [f"pose {i + 1}" for i in places])
        axes.set_ylabel(label)
    figure.axes[0].legend(fontsize=8)
    figure.suptitle("3-PRS: platform at measured slider motions (Table 4)")
    return figure


def writer(figure: Figure) -> Writer:
    """What writes the figure to a path."""
    return lambda path: figure.savefig(path, format="png", dpi=130)
