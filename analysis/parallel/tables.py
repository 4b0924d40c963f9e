"""Tilts that the tables reach at each height, and the 3-PRS beside its printed requirement and measurements."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...models.parallel import prs, three_prs
from ...models.parallel.mast import LIMIT, MAST, STROKE
from ...models.parallel.prs import Table
from ...models.parallel.three_prs import THREE_PRS
from . import cmm

Floats = NDArray[np.float64]

DIRECTIONS = np.deg2rad(np.arange(0.0, 360.0, 5.0))
ARCSEC = np.pi / 180.0 / 3600.0
SINGULAR = 0.02  # smallest singular value of the scaled constraints that counts as regular


@dataclass(frozen=True)
class Tilts:
    """Largest tilt by height and direction, its ring in psi and theta."""

    title: str
    heights: Floats  # over the home position (heights,) [m]
    largest: Floats  # (heights, directions) [rad]
    findings: dict[str, Any]


def mast() -> Tilts:
    """2PRU-1PRS: tilts inside the stroke and away from singularities; x that comes with them."""
    heights = np.linspace(-0.12, 0.12, 7)
    travel = (-0.5 * STROKE, 0.5 * STROKE)
    tilts = _tilts("2PRU-1PRS table", MAST, heights, travel, np.deg2rad(60.0))
    corner = prs.pose(np.array([MAST.home, LIMIT, LIMIT]), MAST)
    tilts.findings["parasitic_x_at_limits_mm"] = float(1e3 * corner.position[0])
    tilts.findings["tilt_in_use_deg"] = float(np.rad2deg(LIMIT))
    tilts.findings["reaches_tilt_in_use_at_home"] = bool(tilts.largest[3].min() >= LIMIT)
    tilts.findings["assumed"] = "sliders travel half their 300 mm stroke to either side of home"
    return tilts


def compliant() -> Tilts:
    """3-PRS: tilts inside the printed travel, requirement, measured poses, stiffness."""
    heights = 1e-3 * np.linspace(-2.0, 2.0, 5)
    travel = (1e-3 * cmm.TRAVEL[0], 1e-3 * cmm.TRAVEL[1])
    tilts = _tilts("3-PRS table", THREE_PRS, heights, travel, np.deg2rad(5.0))
    tilts.findings["requirement"] = requirement()
    tilts.findings["measured"] = measured()
    tilts.findings["stiffness"] = stiffness()
    return tilts


def requirement() -> dict[str, Any]:
    """Travel and joint angles for z of +-2 mm and tilts of +-0.2 deg (section 4), ours and printed."""
    tilt = np.deg2rad([-0.2, 0.0, 0.2])
    task = np.stack(np.meshgrid([-2e-3, 0.0, 2e-3], tilt, tilt), axis=-1).reshape(-1, 3)
    task = task + np.array([THREE_PRS.home, 0.0, 0.0])
    travel = 1e3 * prs.inverse(task, THREE_PRS)
    angles = three_prs.joint_angles(task)
    off = angles._replace(revolute=angles.revolute - three_prs.SLOPE)
    parasitic = three_prs.parasitic(task[:, 1], task[:, 2])
    return {
        "travel_mm": {"ours": [float(travel.min()), float(travel.max())], "printed": cmm.TRAVEL},
        "joints_deg": {
            name: {"ours": float(np.rad2deg(np.abs(values).max())), "printed": cmm.ANGLES[name]}
            for name, values in off._asdict().items()
        },
        "parasitic": {
            "x_um": float(1e6 * np.abs(parasitic[:, 0]).max()),
            "y_um": float(1e6 * np.abs(parasitic[:, 1]).max()),
            "phi_arcsec": float(np.abs(parasitic[:, 2]).max() / ARCSEC),
        },
    }


def measured() -> list[dict[str, Any]]:
    """Forward kinematics at the measured slider motions, beside CMM, FEM and printed FKP (Tables 4-6)."""
    sliders = 1e-6 * np.array([row.sliders for row in cmm.ROWS])
    task = prs.forward(sliders, THREE_PRS) - np.array([THREE_PRS.home, 0.0, 0.0])
    rows = []
    for row, (z, psi, theta) in zip(cmm.ROWS, task):
        ours = {"z_um": 1e6 * z, "psi_arcsec": psi / ARCSEC, "theta_arcsec": theta / ARCSEC}
        printed = {"z_um": row.z, "psi_arcsec": row.psi, "theta_arcsec": row.theta}
        entry: dict[str, Any] = {"sliders_um": row.sliders}
        for name, value in ours.items():
            by_cmm, by_fem, by_fkp = printed[name]
            entry[name] = {
                "cmm": by_cmm,
                "fem": by_fem,
                "printed_fkp": by_fkp,
                "ours": float(value),
                "ours_less_cmm": float(value - by_cmm),
            }
        rows.append(entry)
    return rows


def stiffness() -> list[dict[str, float]]:
    """Force a slider needs against the flexures in a pure z motion, beside Table 2 (finite elements)."""
    rows, h = [], 1e-6
    for force, s in cmm.STIFFNESS:
        ahead, behind = (
            three_prs.elastic_energy(prs.forward(np.full(3, 1e-3 * s + sign * h), THREE_PRS))
            for sign in (1.0, -1.0)
        )
        rows.append(
            {
                "slider_mm": s,
                "printed_N": force,
                "ours_N": float((ahead - behind) / (2.0 * h) / 3.0),
            }
        )
    return rows


def _tilts(
    title: str, table: Table, heights: Floats, travel: tuple[float, float], most: float
) -> Tilts:
    """March outwards in each direction until a slider's stop, an open leg or a singularity."""
    amounts = np.linspace(0.0, most, 241)
    z, direction, amount = np.meshgrid(heights, DIRECTIONS, amounts, indexing="ij")
    task = np.stack(
        [table.home + z, amount * np.cos(direction), amount * np.sin(direction)], axis=-1
    )
    q = prs.inverse(task, table)
    usable = np.asarray(np.isfinite(q).all(axis=-1))
    usable &= (np.nan_to_num(q, nan=np.inf) >= travel[0]).all(axis=-1)
    usable &= (np.nan_to_num(q, nan=np.inf) <= travel[1]).all(axis=-1)
    safe = np.where(usable[..., None], task, [table.home, 0.0, 0.0])
    constraint = prs.twist(prs.pose(safe, table), prs.inverse(safe, table), table).constraint
    smallest = np.linalg.svd(constraint, compute_uv=False)[..., -1]
    usable &= smallest > SINGULAR
    steps = np.argmin(np.concatenate([usable, np.zeros_like(usable[..., :1])], axis=-1), axis=-1)
    largest = amounts[np.maximum(steps - 1, 0)] * (steps > 0)
    found = {
        "travel_mm": [1e3 * travel[0], 1e3 * travel[1]],
        "heights_mm": (1e3 * heights).tolist(),
        "smallest_tilt_limit_deg": np.rad2deg(largest.min(axis=1)).tolist(),
        "largest_tilt_limit_deg": np.rad2deg(largest.max(axis=1)).tolist(),
        "step_deg": float(np.rad2deg(amounts[1])),
        "home_smallest_singular_value": float(smallest[len(heights) // 2, 0, 0]),
    }
    return Tilts(title, heights, largest, found)
