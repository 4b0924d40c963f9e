"""``gapscope workspace pmc``: every question about the workspace, answered as data.

``study`` returns the findings; ``workspace_plots`` and ``workspace_page`` only draw them.
"""

import json
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...models.c_drive import CDriveParameters
from ...models.pmc import kinematics, limits
from ...models.pmc.cycle import IndustryCycle, LameCycle, Placement
from ...models.pmc.geometry import Geometry
from ..resumable import resumable_map
from . import cycle_fit, inscribed, optimum, reach, transmission

Floats = NDArray[np.float64]

# Cells a side of the volume integrals; halving them gives the stated error.
VOLUME_CELLS = 400
# An optimum is confirmed if it meets these: residual of scaled KKT conditions, and distance from the exact height [m].
KKT_TOLERANCE = 1e-6
HEIGHT_TOLERANCE = 1e-9


@dataclass(frozen=True, kw_only=True)
class Body:
    """Largest bodies in one kind of workspace."""

    cuboid: inscribed.Cuboid
    cylinder: inscribed.Cylinder


@dataclass(frozen=True, kw_only=True)
class Study:
    """Findings about the workspace of one geometry."""

    geometry: Geometry
    grid: Floats  # carriage positions of the optimised surfaces [m]
    optima: dict[str, list[list[dict[str, Any] | None]]]  # low, high -> by x, by y
    volumes: dict[str, dict[str, float]]
    bodies: dict[str, Body]
    cycles: list[tuple[Placement, cycle_fit.Slacks]]

    def heights(self, extreme: str) -> Floats:
        """Optimised heights on the grid (n, n) [m], NaN where nothing is feasible."""
        rows = self.optima[extreme]
        return np.array([[np.nan if o is None else o["z"] for o in row] for row in rows])


def study(
    geometry: Geometry,
    folder: Path,
    *,
    grid: int = 13,
    workers: int = 1,
    cluster: str | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Study:
    """Work out everything; ``grid`` optimisations a side and surface, resumed from ``folder``."""
    if grid < 2:
        raise ValueError(f"grid is {grid}; expected at least 2 points a side")
    positions = np.linspace(geometry.carriage_min, geometry.carriage_max, grid)
    cases = [
        {"x": float(x), "ys": positions.tolist(), "extreme": extreme, "geometry": asdict(geometry)}
        for extreme in ("low", "high")
        for x in positions
    ]
    rows = resumable_map(
        optimise_row, cases, folder, workers=workers, cluster=cluster, progress=progress
    )
    turns = {"reachable": None, "half_turn": np.pi, "full_range": 2.0 * np.pi * geometry.turns}
    return Study(
        geometry=geometry,
        grid=positions,
        optima={"low": rows[:grid], "high": rows[grid:]},
        volumes=_volumes(geometry),
        bodies={
            name: Body(
                cuboid=inscribed.largest_cuboid(geometry, turn),
                cylinder=inscribed.largest_cylinder(geometry, turn),
            )
            for name, turn in turns.items()
        },
        cycles=cycle_fit.fit_cycle(geometry),
    )


def optimise_row(
    x: float, ys: list[float], extreme: optimum.Extreme, geometry: dict[str, float]
) -> list[dict[str, Any] | None]:
    """One row of optima at ``x`` as JSON values; None where nothing is feasible."""
    dimensions = Geometry(**geometry)
    found = [optimum.extreme_height(x, y, extreme, dimensions) for y in ys]
    return [None if o is None else asdict(o) | {"joints": o.joints.tolist()} for o in found]


def findings(result: Study) -> dict[str, Any]:
    """What ``workspace.json`` holds: lengths in m, angles in rad, volumes in m^3."""
    geometry = result.geometry
    safe = limits.elevation_limits(geometry)
    return {
        "geometry": asdict(geometry),
        "limits": {
            **asdict(safe),
            "screw_centre": geometry.centre_angle,
            "screw_min": geometry.angle_min,
            "screw_max": geometry.angle_max,
        },
        "volumes_m3": result.volumes,
        "inscribed": {
            name: {
                "cuboid": asdict(body.cuboid) | {"volume_m3": body.cuboid.volume},
                "cylinder": asdict(body.cylinder) | {"volume_m3": body.cylinder.volume},
            }
            for name, body in result.bodies.items()
        },
        "industry_cycle": _cycle_findings(result),
        "rotatability": _rotation_findings(geometry),
        "conditioning": _conditioning_findings(geometry),
        "surfaces": {
            "grid_m": result.grid.tolist(),
            "low_m": _nan_free(result.heights("low")),
            "high_m": _nan_free(result.heights("high")),
            "check": certificate(result),
        },
    }


def certificate(result: Study) -> dict[str, Any]:
    """How well the optimised surfaces are established: KKT, dense grid and exact heights."""
    optima = [o for rows in result.optima.values() for row in rows for o in row if o is not None]
    exact = reach.reachable_surfaces(result.grid[:, None], result.grid, result.geometry)
    errors = [
        np.abs(result.heights(name) - surface) for name, surface in zip(("low", "high"), exact)
    ]
    shortfall = max(abs(o["grid_z"] - o["z"]) for o in optima)
    beyond = max(
        sign * (o["grid_z"] - o["z"])
        for name, sign in (("low", -1.0), ("high", 1.0))
        for row in result.optima[name]
        for o in row
        if o is not None
    )
    values = {
        "optima": len(optima),
        "kkt_residual_max": max(o["kkt_residual"] for o in optima),
        "constraint_violation_max": max(o["violation"] for o in optima),
        "grid_shortfall_max_m": shortfall,
        "grid_shortfall_allowed_m": max(o["grid_bound"] for o in optima),
        "grid_beyond_optimum_max_m": max(beyond, 0.0),
        "exact_error_max_m": float(np.nanmax(errors)),
        "same_points_infeasible": bool(
            all(
                (np.isnan(result.heights(n)) == np.isnan(s)).all()
                for n, s in zip(("low", "high"), exact)
            )
        ),
    }
    values["confirmed"] = bool(
        values["kkt_residual_max"] < KKT_TOLERANCE
        and values["exact_error_max_m"] < HEIGHT_TOLERANCE
        and values["grid_beyond_optimum_max_m"] < HEIGHT_TOLERANCE
        and shortfall <= values["grid_shortfall_allowed_m"]
        and values["same_points_infeasible"]
    )
    return values


def dumps(result: Study) -> str:
    """``workspace.json`` as text."""
    return json.dumps(findings(result), indent=1, allow_nan=False) + "\n"


def centred_posture(x: Floats, y: Floats, z: Floats, geometry: Geometry) -> tuple[Floats, Floats]:
    """Poses with the PM centred at positions of one shape, and their joints (..., 4)."""
    x, y, z, phi = np.broadcast_arrays(x, y, z, geometry.centre_angle)
    poses = np.stack([x, y, z, phi], axis=-1)
    return poses, kinematics.inverse(poses, geometry)


def _volumes(geometry: Geometry) -> dict[str, dict[str, float]]:
    def of(kind: str, n: int) -> float:
        c = reach.cell_centres(geometry, n)
        x, y = c[:, None], c[None, :]
        surfaces = {
            "unbounded": lambda: reach.reachable_surfaces(x, y, geometry, bounded=False),
            "reachable": lambda: reach.reachable_surfaces(x, y, geometry),
            "half_turn": lambda: reach.turning_surfaces(x, y, np.pi, geometry),
            "full_range": lambda: reach.turning_surfaces(
                x, y, 2.0 * np.pi * geometry.turns, geometry
            ),
        }
        return reach.volume(surfaces[kind](), c, c)

    volumes = {}
    for kind in ("unbounded", "reachable", "half_turn", "full_range"):
        value = of(kind, VOLUME_CELLS)
        volumes[kind] = {"value": value, "error": abs(value - of(kind, VOLUME_CELLS // 2))}
    return volumes


def _cycle_findings(result: Study) -> dict[str, Any]:
    placement, slacks = result.cycles[0]
    cycle, rounded = IndustryCycle(placement=placement), LameCycle(placement=placement)
    return {
        "fits": slacks.least >= 0.0,
        "placements": [
            {"placement": asdict(p), "slack_shares": asdict(s)} for p, s in result.cycles
        ],
        "whole_cycle_slack": cycle_fit.cycle_slacks(cycle, result.geometry).least,
        "rounded_cycle_slack": cycle_fit.cycle_slacks(rounded, result.geometry).least,
    }


def _rotation_findings(geometry: Geometry) -> dict[str, Any]:
    c = reach.cell_centres(geometry, 200)
    least, most = reach.extreme_angles(c[:, None], c, geometry)
    return {
        "unbounded_min": float(least.min()),
        "unbounded_max": float(most.max()),
        "screw_range_always_inside": bool(
            (least <= geometry.angle_min).all() and (most >= geometry.angle_max).all()
        ),
        "share_where_unbounded_max_is_positive": float(np.mean(most > 0.0)),
    }


def _conditioning_findings(geometry: Geometry) -> dict[str, Any]:
    c = reach.cell_centres(geometry, 40)
    low, high = reach.turning_surfaces(c[:, None], c, 0.0, geometry)
    share = np.linspace(0.0, 1.0, 41)
    z = low[..., None] + share * (high - low)[..., None]
    poses, joints = centred_posture(c[:, None, None], c[None, :, None], z, geometry)
    condition = kinematics.condition_number(poses, joints, geometry)
    lead = CDriveParameters().lead
    torque = transmission.turning_torque(poses, joints, geometry, lead)
    error = transmission.turning_error(poses, joints, geometry)
    return {
        "isotropic_pose": kinematics.isotropic_pose(geometry).tolist(),
        "condition_number": _spread(condition),
        "motor_torque_per_gripper_torque": _spread(torque),
        "gripper_rotation_per_drive_error": _spread(error),
        "central_axis": _central_axis(geometry),
    }


def _central_axis(geometry: Geometry) -> dict[str, Any]:
    """Motor torque per gripper torque over the heights in the middle of the strokes, PM centred."""
    middle = 0.5 * (geometry.carriage_min + geometry.carriage_max)
    low, high = reach.turning_surfaces(middle, middle, 0.0, geometry)
    z = np.linspace(float(low), float(high), 401)
    poses, joints = centred_posture(np.array(middle), np.array(middle), z, geometry)
    torque = transmission.turning_torque(poses, joints, geometry, CDriveParameters().lead)
    inside = torque[1:-1]
    peaks = 1 + np.flatnonzero((inside > torque[:-2]) & (inside > torque[2:]))
    return {
        "z_m": z[::20].tolist(),
        "motor_torque_per_gripper_torque": torque[::20].tolist(),
        "peak_heights_m": z[peaks].tolist(),
    }


def _spread(values: Floats) -> dict[str, float]:
    return {
        "min": float(values.min()),
        "median": float(np.median(values)),
        "max": float(values.max()),
    }


def _nan_free(values: Floats) -> list[list[float | None]]:
    return [[None if np.isnan(v) else float(v) for v in row] for row in values]
