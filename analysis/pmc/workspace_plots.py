"""Figures of the workspace study: one question a figure, lengths in mm."""

from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d import Axes3D
from numpy.typing import NDArray

from ...models.pmc.cycle import IndustryCycle
from ...models.pmc.geometry import Geometry
from ..files import write_whole
from . import map_plots, reach
from .workspace import Study

Floats = NDArray[np.float64]
# Okabe and Ito's colours, told apart by all.
BLUE, ORANGE, GREEN = "#0072B2", "#D55E00", "#009E73"


def draw_all(result: Study, folder: Path) -> list[Path]:
    """Write every figure as PNG into ``folder``; returns the files."""
    figures = {
        "reachable_workspace.png": reachable_workspace(result),
        "rotatability.png": rotatability(result.geometry),
        "industry_cycle.png": industry_cycle(result),
        **map_plots.figures(result.geometry),
    }
    for name, figure in figures.items():
        image = BytesIO()
        figure.savefig(image, format="png", dpi=130)
        write_whole(folder / name, image.getvalue())
    return [folder / name for name in figures]


def reachable_workspace(result: Study) -> Figure:
    """Where can the PM go? Figs. 2-6a and 2-6b of the thesis."""
    figure = Figure(figsize=(10.0, 5.2), layout="constrained")
    x = np.linspace(result.geometry.carriage_min, result.geometry.carriage_max, 41)
    for place, bounded, title in (
        (1, False, "screws without stops (Fig. 2-6a)"),
        (2, True, "screws of two turns (Fig. 2-6b), dots: optimised"),
    ):
        axes = _axes3d(figure, 120 + place, title)
        low, high = reach.reachable_surfaces(x[:, None], x, result.geometry, bounded=bounded)
        xs, ys = np.meshgrid(x, x, indexing="ij")
        axes.plot_surface(1e3 * xs, 1e3 * ys, 1e3 * low, color=BLUE, alpha=0.45)
        axes.plot_surface(1e3 * xs, 1e3 * ys, 1e3 * high, color=ORANGE, alpha=0.45)
        if bounded:
            gx, gy = np.meshgrid(result.grid, result.grid, indexing="ij")
            for name, colour in (("low", BLUE), ("high", ORANGE)):
                z = result.heights(name)
                axes.scatter(1e3 * gx, 1e3 * gy, 1e3 * z, s=4, color=colour)
    figure.suptitle("Highest (orange) and lowest (blue) position of the PepperMill's centre")
    return figure


def rotatability(geometry: Geometry) -> Figure:
    """How far could the PM turn, and how far do the screws let it? Fig. 2-7."""
    figure = Figure(figsize=(6.4, 5.6), layout="constrained")
    axes = _axes3d(figure, 111, "")
    x = np.linspace(geometry.carriage_min, geometry.carriage_max, 31)
    xs, ys = np.meshgrid(x, x, indexing="ij")
    least, most = reach.extreme_angles(xs, ys, geometry)
    axes.plot_surface(1e3 * xs, 1e3 * ys, least / (2 * np.pi), color=BLUE, alpha=0.5)
    axes.plot_surface(1e3 * xs, 1e3 * ys, most / (2 * np.pi), color=ORANGE, alpha=0.5)
    for turn in (geometry.angle_min, geometry.angle_max):
        flat = np.full_like(xs, turn / (2 * np.pi))
        axes.plot_surface(1e3 * xs, 1e3 * ys, flat, color=GREEN, alpha=0.35)
    axes.set_zlabel("screw angle φ [turns]", labelpad=5.0)
    figure.suptitle(
        "Extreme angles by the drives alone (blue, orange)\nand range of the screws (green)"
    )
    return figure


def industry_cycle(result: Study) -> Figure:
    """Does the industry's cycle fit, seen along its own plane?"""
    placement, slacks = result.cycles[0]
    cycle = IndustryCycle(placement=placement)
    poses = cycle.sample(np.linspace(0.0, 0.5 * cycle.period, 400))[0]
    along = np.linspace(-0.17, 0.17, 300)
    x = placement.x + along * np.cos(placement.direction)
    y = placement.y + along * np.sin(placement.direction)
    geometry = result.geometry
    inside = (np.minimum(x, y) >= geometry.carriage_min) & (
        np.maximum(x, y) <= geometry.carriage_max
    )
    low, high = reach.turning_surfaces(x[inside], y[inside], np.pi, geometry)
    figure = Figure(figsize=(7.2, 4.6), layout="constrained")
    axes = figure.subplots()
    axes.fill_between(
        1e3 * along[inside],
        1e3 * low,
        1e3 * high,
        color=BLUE,
        alpha=0.25,
        lw=0,
        label="half turn possible",
    )
    way = (poses[:, 0] - placement.x) * np.cos(placement.direction) + (
        poses[:, 1] - placement.y
    ) * np.sin(placement.direction)
    axes.plot(1e3 * way, 1e3 * poses[:, 2], color=ORANGE, label="25-300-25 mm cycle")
    axes.set(
        xlabel="along the way across, from its middle [mm]",
        ylabel="z [mm]",
        title=f"Industry cycle at {np.degrees(placement.direction):.0f}° to x; least slack "
        f"{100 * slacks.least:.1f} % of a range (carriages)",
    )
    axes.legend(loc="lower right")
    return figure


def _axes3d(figure: Figure, place: int, title: str) -> Any:
    axes: Axes3D = figure.add_subplot(place, projection="3d")
    axes.set(xlabel="x [mm]", ylabel="y [mm]", title=title)
    axes.set_zlabel("z [mm]", labelpad=9.0)
    axes.view_init(elev=18.0, azim=-125.0)
    axes.set_box_aspect((1.0, 1.0, 1.2), zoom=0.95)
    return axes
