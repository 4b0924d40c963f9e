"""Maps of the PepperMill-Carrier over its whole workspace: rotatability, conditioning and transmission.

All four are taken at points of a regular grid, orientation-dependent ones with the PM centred; NaN where that is out of
reach.
"""

import io
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...models.c_drive import CDriveParameters
from ...models.pmc import kinematics
from ...models.pmc.geometry import Geometry
from . import reach, transmission

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Maps:
    """Values over a grid, arrays (heights, points along x, points along y)."""

    x: Floats  # (n,) [m], and the same along y
    z: Floats  # (m,) [m]
    rotation: Floats  # that the screws and drives allow [rad], 0 outside the workspace
    condition: Floats  # condition number of the Jacobian [-]
    torque: Floats  # largest motor torque per torque about the PM's axis [-]
    error: Floats  # rotation of the PM per error of one drive angle [rad/rad]


def maps(geometry: Geometry, *, n: int = 41, heights: Floats | None = None) -> Maps:
    """Maps at ``n`` points a side and ``heights`` [m], by default 25 from the lowest to the highest point."""
    x = np.linspace(geometry.carriage_min, geometry.carriage_max, n)
    if heights is None:
        low, high = reach.reachable_surfaces(x[:, None], x, geometry)
        heights = np.linspace(float(np.nanmin(low)), float(np.nanmax(high)), 25)
    z = np.asarray(heights, dtype=float)
    grid = np.meshgrid(z, x, x, indexing="ij")
    rotation = reach.rotatability(grid[1], grid[2], grid[0], geometry)
    condition, torque, error = np.full((3, *rotation.shape), np.nan)
    low, high = reach.turning_surfaces(x[:, None], x, 0.0, geometry)
    inside = (grid[0] >= low) & (grid[0] <= high)
    poses = np.column_stack(
        [
            grid[1][inside],
            grid[2][inside],
            grid[0][inside],
            np.full(inside.sum(), geometry.centre_angle),
        ]
    )
    joints = kinematics.inverse(poses, geometry)
    condition[inside] = kinematics.condition_number(poses, joints, geometry)
    torque[inside] = transmission.turning_torque(poses, joints, geometry, CDriveParameters().lead)
    error[inside] = transmission.turning_error(poses, joints, geometry)
    return Maps(x=x, z=z, rotation=rotation, condition=condition, torque=torque, error=error)


def table(found: Maps) -> str:
    """CSV of every grid point inside the workspace; empty cells where the centred PM is out of reach."""
    z, x, y = np.meshgrid(found.z, found.x, found.x, indexing="ij")
    columns = {
        "x_m": x,
        "y_m": y,
        "z_m": z,
        "rotation_rad": found.rotation,
        "condition_number": found.condition,
        "motor_torque_per_gripper_torque": found.torque,
        "gripper_rotation_per_drive_error": found.error,
    }
    inside = found.rotation > 0.0
    text = io.StringIO()
    text.write(",".join(columns) + "\n")
    for row in zip(*(values[inside] for values in columns.values())):
        text.write(",".join("" if np.isnan(v) else f"{v:.6g}" for v in row) + "\n")
    return text.getvalue()
