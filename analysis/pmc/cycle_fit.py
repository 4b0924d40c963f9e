"""Where the industry's test cycle fits into the workspace of the PepperMill-Carrier, and how well.

The slack of a joint limit is its distance from the nearer bound as a share of the range: 0.5 in the middle, negative
outside. The fit is the placement whose product of the three least slacks (carriages, drive angles, screws)
is largest, the analytic centre; the carriages alone would leave the others undetermined, for the way
across needs 212 of their 216 mm.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, differential_evolution, minimize

from ...models.pmc import kinematics, limits
from ...models.pmc.cycle import IndustryCycle, LameCycle, Placement
from ...models.pmc.geometry import Geometry

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Slacks:
    """Least slack of each kind of limit along a path, shares of the ranges [-]."""

    carriage: float
    drive: float
    screw: float

    @property
    def least(self) -> float:
        """Smallest of the three; the path fits if it is not negative."""
        return min(self.carriage, self.drive, self.screw)


def path_slacks(poses: Floats, geometry: Geometry) -> Slacks:
    """Slacks of a path of poses (n, 4); poses out of reach count as -1."""
    joints = kinematics.inverse(poses, geometry)
    bounds = limits.theta_bounds(geometry)
    drive = min(_slack(joints[:, 2 + i], *bounds[i]) for i in (0, 1))
    return Slacks(
        carriage=_slack(joints[:, :2], geometry.carriage_min, geometry.carriage_max),
        drive=drive,
        screw=_slack(poses[:, 3], geometry.angle_min, geometry.angle_max),
    )


def fit_cycle(geometry: Geometry, seed: int = 1) -> list[tuple[Placement, Slacks]]:
    """Best placement of the industry cycle on either diagonal with its slacks, the better one first.

    Directions of 0 to 90 and of 90 to 180 degrees are searched apart; with a path run both ways and screws of symmetric
    range that covers both senses of the turn. A negative slack means that the cycle does not fit.
    """
    found = [_fit(geometry, seed, half) for half in ((0.0, np.pi / 2), (np.pi / 2, np.pi))]
    return sorted(found, key=lambda fit: _quality(fit[1]))


def _fit(
    geometry: Geometry, seed: int, directions: tuple[float, float], samples: int = 101
) -> tuple[Placement, Slacks]:
    stroke = (geometry.carriage_min, geometry.carriage_max)
    heights = (-(geometry.proximal + geometry.distal), geometry.proximal)
    turns = (geometry.angle_min, geometry.angle_max)
    bounds = Bounds(*np.transpose([stroke, stroke, heights, turns, directions]))

    def slacks(v: Floats) -> Slacks:
        cycle = IndustryCycle(placement=_placement(v))
        times = np.linspace(0.0, 0.5 * cycle.period, samples)
        return path_slacks(cycle.sample(times)[0], geometry)

    def cost(v: Floats) -> float:
        return _quality(slacks(v))

    rough = differential_evolution(
        cost, bounds, seed=seed, popsize=15, maxiter=300, tol=1e-9, polish=False
    )
    options: Any = {"xatol": 1e-9, "fatol": 1e-10, "maxiter": 5000, "adaptive": True}
    best = minimize(cost, rough.x, bounds=bounds, method="Nelder-Mead", options=options)
    best = minimize(cost, best.x, bounds=bounds, method="Nelder-Mead", options=options)
    return _placement(best.x), slacks(best.x)


def cycle_slacks(cycle: IndustryCycle | LameCycle, geometry: Geometry, n: int = 2001) -> Slacks:
    """Slacks of a whole cycle at ``n`` times."""
    return path_slacks(cycle.sample(np.linspace(0.0, cycle.period, n))[0], geometry)


def _quality(slacks: Slacks) -> float:
    """Small is good: minus the logarithm of the product of the slacks, large where one is negative."""
    if slacks.least <= 0.0:
        return 100.0 - slacks.least
    return -float(np.log([slacks.carriage, slacks.drive, slacks.screw]).sum())


def _placement(v: Floats) -> Placement:
    x, y, z, phi, direction = (float(value) for value in v)
    return Placement(x=x, y=y, z=z, phi=phi, direction=direction)


def _slack(values: Floats, low: float, high: float) -> float:
    inside = np.minimum(values - low, high - values) / (high - low)
    least = float(np.min(inside))
    return least if np.isfinite(least) else -1.0
