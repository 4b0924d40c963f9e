r"""What the PepperMill-Carrier can reach: exact surfaces from its joint limits.

1. At fixed x and y each wrist height :math:`v_i` grows with its drive angle between the safe limits (2.19), so
   :math:`v_i \in [a_i, b_i]`; limb 1 reaches y and limb 2 reaches x.
2. :math:`z = (v_1 + v_2)/2`, and the screws allow :math:`|v_1 - v_2| \le 2 p \pi n` about the centred PM, n turns
   (2.20)-(2.21).
3. The extreme heights (2.27)-(2.28) are therefore those of a linear programme in :math:`(v_1, v_2)`:
   :math:`z_{max} = \frac12[\min(b_1, b_2 + s) + \min(b_2, b_1 + s)]`, :math:`s = 2p\pi n`; for
   :math:`z_{min}` likewise with max and :math:`-s`.
4. All turns within :math:`\pm\Delta` of the centre are possible for
   :math:`\max(a_i) + p\Delta \le z \le \min(b_i) - p\Delta`.

The thesis solves (3) by sequential quadratic programming only; ``optimum`` repeats that as a check. Lengths in
m, angles in rad, frames as in ``models.pmc``. Not modelled: interference of links and frame.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...models.pmc import limb, limits
from ...models.pmc.geometry import Geometry

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class WristRanges:
    """Intervals of the wrist heights over their drive axes [m], law (1)."""

    low1: Floats
    high1: Floats
    low2: Floats
    high2: Floats

    def surfaces(self, spread: float) -> tuple[Floats, Floats]:
        """Law (3) for :math:`|v_1 - v_2|` up to ``spread`` [m]: (z_min, z_max), NaN where empty."""
        low = 0.5 * (
            np.maximum(self.low1, self.low2 - spread) + np.maximum(self.low2, self.low1 - spread)
        )
        high = 0.5 * (
            np.minimum(self.high1, self.high2 + spread)
            + np.minimum(self.high2, self.high1 + spread)
        )
        gap = np.maximum(self.low1 - self.high2, self.low2 - self.high1)
        return _nan_where(gap > spread, low, high)

    def turning_surfaces(self, offset: float) -> tuple[Floats, Floats]:
        r"""Law (4) for :math:`p\Delta` = ``offset`` [m]: (z_min, z_max), NaN where empty."""
        low = np.maximum(self.low1, self.low2) + offset
        high = np.minimum(self.high1, self.high2) - offset
        return _nan_where(low > high, low, high)


def wrist_ranges(x: ArrayLike, y: ArrayLike, geometry: Geometry) -> WristRanges:
    """Law (1) at positions ``x``, ``y`` (any common shape)."""
    safe = limits.elevation_limits(geometry)
    low1, high1 = (_height(y, alpha, geometry) for alpha in (safe.safe_min, safe.safe_max))
    low2, high2 = (_height(x, alpha, geometry) for alpha in (safe.safe_min, safe.safe_max))
    return WristRanges(*np.broadcast_arrays(low1, high1, low2, high2))


def rectangle_ranges(
    x: tuple[ArrayLike, ArrayLike], y: tuple[ArrayLike, ArrayLike], geometry: Geometry
) -> WristRanges:
    """Wrist heights that every point of the rectangles x0..x1, y0..y1 allows.

    A wrist height is convex in the reach, least where the distal link hangs: the lower bound is worst at a
    corner and the upper one where the link hangs, or at the nearest edge.
    """
    safe = limits.elevation_limits(geometry)
    hang = geometry.proximal * np.cos(safe.safe_max)

    def allowed(first: ArrayLike, last: ArrayLike) -> tuple[Floats, Floats]:
        ends = (_height(end, safe.safe_min, geometry) for end in (first, last))
        nearest = np.clip(hang, first, last)
        return np.maximum(*ends), _height(nearest, safe.safe_max, geometry)

    return WristRanges(*np.broadcast_arrays(*allowed(*y), *allowed(*x)))


def screw_spread(geometry: Geometry) -> float:
    """Largest difference of the wrist heights that the screws allow [m], law (2)."""
    return 2.0 * geometry.pitch * np.pi * geometry.turns


def reachable_surfaces(
    x: ArrayLike, y: ArrayLike, geometry: Geometry, *, bounded: bool = True
) -> tuple[Floats, Floats]:
    """Lowest and highest z reached in some orientation (Figs. 2-6b and, unbounded, 2-6a)."""
    spread = screw_spread(geometry) if bounded else np.inf
    return wrist_ranges(x, y, geometry).surfaces(spread)


def turning_surfaces(
    x: ArrayLike, y: ArrayLike, turn: float, geometry: Geometry
) -> tuple[Floats, Floats]:
    """Lowest and highest z at which the PM turns by ``turn`` [rad] about its centred angle."""
    return wrist_ranges(x, y, geometry).turning_surfaces(0.5 * geometry.pitch * turn)


def extreme_angles(x: ArrayLike, y: ArrayLike, geometry: Geometry) -> tuple[Floats, Floats]:
    """Extreme screw angles at any height with unbounded screws, eq. (2.26), Fig. 2-7: (min, max)."""
    wrists = wrist_ranges(x, y, geometry)
    least = 0.5 * (wrists.low1 - wrists.high2) / geometry.pitch
    most = 0.5 * (wrists.high1 - wrists.low2) / geometry.pitch
    return geometry.centre_angle + least, geometry.centre_angle + most


def rotatability(x: ArrayLike, y: ArrayLike, z: ArrayLike, geometry: Geometry) -> Floats:
    """Angle that the PM turns through at each position [rad]: 0 outside the workspace, at most n turns."""
    wrists = wrist_ranges(x, y, geometry)
    z = np.asarray(z, dtype=float)
    reach = np.pi * geometry.turns * geometry.pitch
    least = np.maximum(np.maximum(wrists.low1 - z, z - wrists.high2), -reach)
    most = np.minimum(np.minimum(wrists.high1 - z, z - wrists.low2), reach)
    return np.maximum(most - least, 0.0) / geometry.pitch


def volume(surfaces: tuple[Floats, Floats], x: Floats, y: Floats) -> float:
    """Volume between two surfaces sampled at cell centres of a regular grid x (m,), y (n,) [m^3]."""
    low, high = surfaces
    cell = (x[1] - x[0]) * (y[1] - y[0])
    return float(np.nansum(high - low) * cell)


def cell_centres(geometry: Geometry, n: int) -> Floats:
    """Centres of ``n`` equal cells of the carriage stroke [m]."""
    edges = np.linspace(geometry.carriage_min, geometry.carriage_max, n + 1)
    return 0.5 * (edges[1:] + edges[:-1])


def _height(h: ArrayLike, alpha: float, geometry: Geometry) -> Floats:
    reach = np.asarray(h, dtype=float)
    return limb.wrist_height(reach, alpha, -1.0, geometry.proximal, geometry.distal)


def _nan_where(empty: NDArray[np.bool_], low: Floats, high: Floats) -> tuple[Floats, Floats]:
    return np.where(empty, np.nan, low), np.where(empty, np.nan, high)
