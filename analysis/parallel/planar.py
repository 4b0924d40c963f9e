"""Joint space and workspace of 5R, RePlaLink and 2-PRR (Roldan, Figs. 4.2, 6.1b, 6.4, 6.14)."""

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...models.parallel import five_bar, two_prr
from ...models.parallel.five_bar import FiveBar
from ...models.parallel.replalink import REPLALINK
from ...models.parallel.two_prr import TwoPRR
from ..identification.machine import Machine
from ..identification.machines import machine
from ..identification.polygon import inside

Floats = NDArray[np.float64]

MODES = tuple(product((1, -1), repeat=2))
PRINTED_RECTANGLE = (0.40, 0.86, -0.68, -0.41)  # of the 2-PRR: x, y [m], Fig. 6.1b


@dataclass(frozen=True)
class Planar:
    """Joint space, its image, and how well the tool moves there."""

    title: str
    unit: str  # of the axes
    joint_space: Floats  # (vertices, 2)
    boundary: Floats  # of the workspace, image of the joint space's edge [m]
    tools: Floats  # points inside (points, 2) [m]
    dexterity: Floats  # smallest over largest singular value of the tool's Jacobian there
    findings: dict[str, Any]


def linkage(name: str) -> Planar:
    """Five-bar ``5r`` or ``replalink``, assembled with C left of A to B."""
    m = machine(name)
    dimensions = FiveBar() if name == "5r" else REPLALINK
    ring = np.asarray(m.polygon)

    def tool(q: Floats) -> Floats:
        return five_bar.forward(q, dimensions).tool

    def rows(q: Floats) -> Floats:
        motion = five_bar.motion(q, np.zeros_like(q), dimensions)
        return motion.jacobian[..., five_bar.BODIES.index("tool"), :2, :]

    planar = _planar(m.title, "rad", ring, tool, rows)
    everywhere = _grid(-1.4, 1.4, -1.4, 1.4, 141)
    areas = {
        f"{one:+d}, {two:+d}": _area(
            everywhere, five_bar.inverse(everywhere, dimensions, (one, two)), m, 2.0 * np.pi
        )
        for one, two in MODES
    }
    planar.findings["area_by_working_mode_m2"] = areas
    planar.findings["note"] = (
        "Working modes (sides of A and B) are counted inside the travel, singular or not, on a grid of 20 mm. The "
        "source prints no number of these figures to compare with."
    )
    return planar


def slider_pair() -> Planar:
    """2-PRR: the rectangle of travel and what the platform's joint reaches, beside Fig. 6.1b."""
    m, dimensions = machine("2prr"), TwoPRR()
    (low1, low2), (high1, high2) = m.lower, m.upper
    ring = _densely(np.array([(low1, low2), (high1, low2), (high1, high2), (low1, high2)]))

    def rows(q: Floats) -> Floats:
        motion = two_prr.motion(q, np.zeros_like(q), dimensions)
        return motion.jacobian[..., two_prr.BODIES.index("platform"), :2, :]

    planar = _planar(m.title, "m", ring, lambda q: two_prr.forward(q, dimensions), rows)
    left, right, bottom, top = PRINTED_RECTANGLE
    planar.findings["printed_rectangle_m"] = {"x": [left, right], "y": [bottom, top]}
    planar.findings["printed_rectangle"] = _contained(planar.boundary, PRINTED_RECTANGLE)
    everywhere = _grid(-0.6, 1.9, -0.7, 0.0, 141)
    planar.findings["area_by_working_mode_m2"] = {
        f"{one:+d}, {two:+d}": _area(
            everywhere, two_prr.inverse(everywhere, dimensions, (one, two)), m
        )
        for one, two in MODES
    }
    planar.findings["note"] = (
        "The printed rectangle reaches y = -0.68 m, deeper than a bar is long (0.654 m): it belongs to a point below "
        "the platform's joint whose offset is not printed."
    )
    return planar


def _planar(title: str, unit: str, ring: Floats, tool: Any, rows: Any) -> Planar:
    (x0, y0), (x1, y1) = ring.min(axis=0), ring.max(axis=0)
    q = _grid(x0, x1, y0, y1, 90)
    q = q[inside(q, ring) > 1e-3 * (x1 - x0)]
    singular = np.linalg.svd(rows(q), compute_uv=False)
    dexterity = singular[..., 1] / singular[..., 0]
    boundary = tool(_densely(ring))
    points = tool(q)
    found = {
        "joint_space": {"vertices": ring.tolist(), "unit": unit, "area": _shoelace(ring)},
        "workspace": {
            "area_m2_in_20_mm_cells": _covered(points),
            "x_m": [float(points[:, 0].min()), float(points[:, 0].max())],
            "y_m": [float(points[:, 1].min()), float(points[:, 1].max())],
        },
        "dexterity": {"smallest": float(dexterity.min()), "largest": float(dexterity.max())},
    }
    return Planar(title, unit, ring, boundary, points, dexterity, found)


def _contained(boundary: Floats, rectangle: tuple[float, float, float, float]) -> dict[str, Any]:
    """The shift of the rectangle that holds the most of it in the workspace, and how much that is."""
    left, right, bottom, top = rectangle
    points = _grid(left, right, bottom, top, 12)
    shifts = _grid(-0.2, 0.2, -0.1, 0.4, 21)
    moved = points[None] + shifts[:, None]
    share = np.concatenate(
        [(inside(part, boundary) >= -1e-9).mean(axis=-1) for part in np.array_split(moved, 40)]
    )
    best = int(np.argmax(share))
    as_printed = (inside(points, boundary) >= -1e-9).mean()
    return {
        "share_inside_as_printed": float(as_printed),
        "largest_share_inside": float(share[best]),
        "shift_for_it_m": shifts[best].tolist(),
    }


def _grid(x0: float, x1: float, y0: float, y1: float, count: int) -> Floats:
    x, y = np.meshgrid(np.linspace(x0, x1, count), np.linspace(y0, y1, count))
    return np.stack([x.ravel(), y.ravel()], axis=-1)


def _area(points: Floats, solution: Floats, m: Machine, turn: float = np.inf) -> float:
    """Area [m^2] of grid points whose solution lies in the travel, angles up to whole turns."""
    above = solution - m.lower
    if np.isfinite(turn):
        above = np.mod(above, turn)
    with np.errstate(invalid="ignore"):
        usable = ((above >= 0.0) & (above <= m.upper - m.lower)).all(axis=-1)
    spans = np.ptp(points, axis=0)
    return float(usable.mean() * spans[0] * spans[1])


def _covered(points: Floats, cell: float = 0.02) -> float:
    """Area [m^2] of the square cells that hold a point; right where the image folds over, too."""
    return float(len(np.unique(np.floor(points / cell), axis=0)) * cell**2)


def _densely(ring: Floats, pieces: int = 12) -> Floats:
    share = np.arange(pieces)[:, None, None] / pieces
    steps = ring + share * (np.roll(ring, -1, axis=0) - ring)
    return np.asarray(np.swapaxes(steps, 0, 1).reshape(-1, 2))


def _shoelace(ring: Floats) -> float:
    x, y = ring.T
    return float(0.5 * abs(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
