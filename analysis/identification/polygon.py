"""Polygons in the plane of two actuated coordinates."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def inside(points: ArrayLike, polygon: ArrayLike) -> Floats:
    """Distance (...) of points (..., 2) to the edge of a polygon (vertices, 2), positive inside it."""
    p, corners = np.asarray(points, dtype=float)[..., None, :], np.asarray(polygon, dtype=float)
    edge = np.roll(corners, -1, axis=0) - corners
    to_corner = p - corners
    length = np.einsum("vi,vi->v", edge, edge)
    share = np.clip(np.einsum("...vi,vi->...v", to_corner, edge) / length, 0.0, 1.0)
    off = to_corner - share[..., None] * edge
    nearest = np.sqrt(np.min(np.einsum("...vi,...vi->...v", off, off), axis=-1))
    # Even-odd rule: crossings of the ray in +x.
    y = p[..., 1]
    low, high = corners[:, 1], np.roll(corners, -1, axis=0)[:, 1]
    straddles = (low > y) != (high > y)
    rise = np.where(edge[:, 1] == 0.0, 1.0, edge[:, 1])
    crossing = corners[:, 0] + (y - low) * edge[:, 0] / rise
    odd = np.sum(straddles & (p[..., 0] < crossing), axis=-1) % 2 == 1
    return np.asarray(np.where(odd, nearest, -nearest))
