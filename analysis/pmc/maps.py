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
    return Maps(x=x, z=z, **_values(x[:, None], x, z[:, None, None], geometry))


def diagonal(geometry: Geometry, *, n: int = 61, heights: int = 121) -> Maps:
    """Maps over the vertical section x = y, with 5 mm around it: arrays (heights, points along x = y)."""
    x = np.linspace(geometry.carriage_min, geometry.carriage_max, n)
    low, high = reach.reachable_surfaces(x, x, geometry)
    z = np.linspace(low.min() - 0.005, high.max() + 0.005, heights)
    return Maps(x=x, z=z, **_values(x, x, z[:, None], geometry))


def _values(x: Floats, y: Floats, z: Floats, geometry: Geometry) -> dict[str, Floats]:
    """The fields of ``Maps`` at points [m]."""
    low, high = reach.turning_surfaces(x, y, 0.0, geometry)
    wide_x, wide_y, wide_z = np.broadcast_arrays(x, y, z)
    inside = (z >= low) & (z <= high)
    angle = np.full(inside.sum(), geometry.centre_angle)
    poses = np.column_stack([wide_x[inside], wide_y[inside], wide_z[inside], angle])
    joints = kinematics.inverse(poses, geometry)
    condition, torque, error = np.full((3, *inside.shape), np.nan)
    condition[inside] = kinematics.condition_number(poses, joints, geometry)
    torque[inside] = transmission.turning_torque(poses, joints, geometry, CDriveParameters().lead)
    error[inside] = transmission.turning_error(poses, joints, geometry)
    rotation = reach.rotatability(wide_x, wide_y, wide_z, geometry)
    return {"rotation": rotation, "condition": condition, "torque": torque, "error": error}


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
