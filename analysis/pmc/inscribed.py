"""Largest upright cuboid and cylinder inside the workspace of the PepperMill-Carrier.

A body fits if its whole ground plan lies in the carriage strokes and its height between the surfaces of
``reach`` over every point of the plan. Two kinds of workspace: reachable in some orientation, and turning by a given
angle everywhere. Global search by seeded differential evolution, polished by Nelder-Mead.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, differential_evolution, minimize

from ...models.pmc.geometry import Geometry
from . import reach

Floats = NDArray[np.float64]
# Polar samples of a disc while searching and for the final height of the cylinder.
SEARCH = (6, 48)
FINAL = (60, 720)


@dataclass(frozen=True, kw_only=True)
class Cuboid:
    """Upright cuboid, sides along x and y [m]."""

    x: tuple[float, float]
    y: tuple[float, float]
    z: tuple[float, float]

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return float(np.prod([high - low for low, high in (self.x, self.y, self.z)]))


@dataclass(frozen=True, kw_only=True)
class Cylinder:
    """Upright cylinder [m]."""

    centre: tuple[float, float]
    radius: float
    z: tuple[float, float]

    @property
    def volume(self) -> float:
        """Volume [m^3]."""
        return float(np.pi * self.radius**2 * (self.z[1] - self.z[0]))


def largest_cuboid(geometry: Geometry, turn: float | None = None, seed: int = 1) -> Cuboid:
    """Largest cuboid; with ``turn`` [rad], every point of it allows that rotation.

    Variables: the two edges along x and along y. The height follows exactly (``reach.rectangle_ranges``).
    """
    stroke = (geometry.carriage_min, geometry.carriage_max)

    def plan(v: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
        return _pair(np.sort(v[:2])), _pair(np.sort(v[2:]))

    def heights(v: Floats) -> tuple[float, float]:
        x, y = plan(v)
        low, high = _surfaces(reach.rectangle_ranges(x, y, geometry), turn, geometry)
        return float(low), float(high)

    def volume(v: Floats) -> float:
        low, high = heights(v)
        return float(abs(v[1] - v[0]) * abs(v[3] - v[2]) * max(high - low, 0.0)) or 0.0

    best = _search(volume, [stroke] * 4, seed)
    x, y = plan(best)
    return Cuboid(x=x, y=y, z=heights(best))


def largest_cylinder(geometry: Geometry, turn: float | None = None, seed: int = 1) -> Cylinder:
    """Largest cylinder; with ``turn`` [rad], every point of it allows that rotation.

    Variables: centre, and radius as a share of what the stroke leaves. The height is the least over polar samples of
    the disc, at the end over 60 x 720 of them.
    """
    first, last = geometry.carriage_min, geometry.carriage_max

    def radius(v: Floats) -> float:
        return float(v[2] * min(v[0] - first, last - v[0], v[1] - first, last - v[1]))

    def heights(v: Floats, samples: tuple[int, int]) -> tuple[float, float]:
        rings = radius(v) * np.linspace(0.0, 1.0, samples[0])[:, None]
        around = np.linspace(0.0, 2.0 * np.pi, samples[1], endpoint=False)
        x = np.clip(v[0] + rings * np.cos(around), first, last)
        y = np.clip(v[1] + rings * np.sin(around), first, last)
        low, high = _surfaces(reach.wrist_ranges(x, y, geometry), turn, geometry)
        return float(low.max()), float(high.min())

    def volume(v: Floats) -> float:
        low, high = heights(v, SEARCH)
        return float(np.pi * radius(v) ** 2 * max(high - low, 0.0)) or 0.0

    best = _search(volume, [(first, last), (first, last), (0.0, 1.0)], seed)
    return Cylinder(
        centre=(float(best[0]), float(best[1])), radius=radius(best), z=heights(best, FINAL)
    )


def _surfaces(
    wrists: reach.WristRanges, turn: float | None, geometry: Geometry
) -> tuple[Floats, Floats]:
    if turn is None:
        return wrists.surfaces(reach.screw_spread(geometry))
    return wrists.turning_surfaces(0.5 * geometry.pitch * turn)


def _search(
    volume: Callable[[Floats], float], bounds: Sequence[tuple[float, float]], seed: int
) -> Floats:
    """Argument of the largest ``volume`` (litres inside, so that tolerances are sensible)."""

    def cost(v: Floats) -> float:
        value = volume(v)
        return -1e3 * value if np.isfinite(value) else 0.0

    box = Bounds(*np.transpose(bounds))
    rough = differential_evolution(cost, box, seed=seed, popsize=20, tol=1e-8, polish=False)
    polished = minimize(
        cost,
        rough.x,
        bounds=box,
        method="Nelder-Mead",
        options={"xatol": 1e-9, "fatol": 1e-12, "maxiter": 4000},
    )
    return np.asarray(polished.x if polished.fun <= rough.fun else rough.x)


def _pair(values: Floats) -> tuple[float, float]:
    return float(values[0]), float(values[1])
