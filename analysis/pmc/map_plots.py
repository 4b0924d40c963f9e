"""Figures of the maps: horizontal sections at several heights, and the vertical section over the diagonal x = y."""

from dataclasses import dataclass

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from ...models.pmc import kinematics
from ...models.pmc.geometry import Geometry
from . import maps, reach

Floats = NDArray[np.float64]
HEIGHTS = (-0.40, -0.30, -0.20, -0.10, 0.0)  # of the horizontal sections [m]


@dataclass(frozen=True, kw_only=True)
class Quantity:
    """What one figure shows: a field of ``Maps``, in words, and the factor to its unit."""

    field: str
    title: str
    label: str
    factor: float = 1.0


QUANTITIES = {
    "rotation_at_height.png": Quantity(
        field="rotation", title="Rotation available", label="turns", factor=0.5 / np.pi
    ),
    "conditioning.png": Quantity(
        field="condition", title="Condition number, PM centred", label="condition number [-]"
    ),
    "transmission.png": Quantity(
        field="torque",
        title="Largest motor torque to turn the gripper, PM centred",
        label="motor torque per gripper torque [N m / N m]",
    ),
    "sensitivity.png": Quantity(
        field="error",
        title="Rotation of the gripper per error of one drive, PM centred",
        label="rotation per drive error [rad/rad]",
    ),
}


def figures(geometry: Geometry) -> dict[str, Figure]:
    """Every figure by the name of its file."""
    level = maps.maps(geometry, n=61, heights=np.array(HEIGHTS))
    upright = maps.diagonal(geometry)
    return {
        name: _figure(quantity, level, upright, geometry) for name, quantity in QUANTITIES.items()
    }


def _figure(quantity: Quantity, level: maps.Maps, upright: maps.Maps, geometry: Geometry) -> Figure:
    figure = Figure(figsize=(11.5, 6.6), layout="constrained")
    axes = figure.subplots(2, 3).ravel()
    flat, tall = (quantity.factor * getattr(m, quantity.field) for m in (level, upright))
    if quantity.field == "rotation":
        flat, tall = (np.where(values > 0.0, values, np.nan) for values in (flat, tall))
    both = np.concatenate([flat.ravel(), tall.ravel()])
    lowest = 0.0 if quantity.field == "rotation" else np.nanmin(both)
    levels = np.linspace(lowest, np.nanmax(both), 17)
    for ax, z, values in zip(axes, level.z, flat):
        ax.contourf(1e3 * level.x, 1e3 * level.x, values.T, levels=levels, cmap="cividis")
        ax.set(title=f"z = {1e3 * z:.0f} mm", xlabel="x [mm]", ylabel="y [mm]", aspect="equal")
    last = axes[-1]
    filled = last.contourf(1e3 * upright.x, 1e3 * upright.z, tall, levels=levels, cmap="cividis")
    for surface in reach.reachable_surfaces(upright.x, upright.x, geometry):
        last.plot(1e3 * upright.x, 1e3 * surface, color="#666666", lw=1.0)
    last.set(title="over the diagonal x = y", xlabel="x = y [mm]", ylabel="z [mm]")
    if quantity.field == "condition":
        isotropic = 1e3 * kinematics.isotropic_pose(geometry)
        last.plot(isotropic[0], isotropic[2], "o", color="white", mec="black")
        last.annotate(
            "isotropic", isotropic[[0, 2]], xytext=(8, 6), textcoords="offset points", color="white"
        )
    figure.colorbar(filled, ax=axes, label=quantity.label, format="%.3g", shrink=0.8)
    figure.suptitle(quantity.title)
    return figure
