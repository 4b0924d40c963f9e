"""Estimates: base parameters with intervals, completion by trusted parameters (5.5), feasible least squares."""

from itertools import combinations
from math import comb
from typing import NamedTuple

import numpy as np
import scipy.optimize
import scipy.stats
from numpy.typing import NDArray

from .base import Base
from .machine import Machine
from .measurement import Regression

Floats = NDArray[np.float64]

CERTAINTY = 0.95
MANY = 5000  # combinations of trusted parameters that are tried at most


class Fit(NamedTuple):
    """Weighted least squares of the base parameters."""

    values: Floats  # (base,)
    half_width: Floats  # of the 95 % interval (base,)
    scatter: Floats  # residual standard deviation of each axis (n,)


class Completion(NamedTuple):
    """Individual parameters from base parameters and combinations of trusted ones (5.36)-(5.43)."""

    total: int  # combinations there are
    tried: int
    usable: int  # with a regular matrix C
    mean: Floats  # over usable combinations (parameters,)
    deviation: Floats
    low: Floats  # smallest positive value, NaN where there is none
    high: Floats
    optimum: Floats  # inside low .. high, closest to the forces


def fit(data: Regression, base: Base, axes: int) -> Fit:
    r"""Least squares on the kept columns, each axis weighted by its own scatter.

    Rows as close as the filter's memory err alike. With their correlation R, that of white sensor noise behind the
    filter, the estimate's covariance is :math:`\sigma^2 A X^T R X A,\ A = (X^T X)^{-1}`, and the residuals'
    expected square :math:`\sigma^2 (rows - tr(A X^T R X))`.
    """
    w = data.regressor[:, list(base.kept)]
    first = np.linalg.lstsq(w, data.force, rcond=None)[0]
    scatter = _scatter(data.force - w @ first, data.axis, axes)
    weight = 1.0 / scatter[data.axis]
    scaled = w * weight[:, None]
    values = np.linalg.lstsq(scaled, data.force * weight, rcond=None)[0]
    left = data.force - w @ values
    scatter = _scatter(left, data.axis, axes)
    inverse = np.linalg.inv(scaled.T @ scaled)
    alike = inverse @ _correlated(scaled, data)
    freedom = len(data.force) - float(np.trace(alike))
    variance = float(np.sum((left * weight) ** 2)) / freedom
    spread = np.sqrt(variance * np.diag(alike @ inverse))
    return Fit(
        np.asarray(values, dtype=float),
        scipy.stats.t.ppf(0.5 + 0.5 * CERTAINTY, freedom) * spread,
        scatter,
    )


def complete(machine: Machine, base: Base, values: Floats, data: Regression) -> Completion | None:
    """Every usable combination of trusted parameters; None where none are needed, or too few are known."""
    names = machine.names
    lacking = len(names) - len(values)
    trusted = [names.index(name) for name in machine.trusted]
    if not 0 < lacking <= len(trusted):
        return None
    total = comb(len(trusted), lacking)
    chosen = np.array(list(combinations(trusted, lacking))[:MANY], dtype=int).reshape(-1, lacking)
    known = np.concatenate([machine.prior, np.zeros(2 * machine.axes)])
    matrices = np.zeros((len(chosen), len(names), len(names)))
    right = np.zeros((len(chosen), len(names)))
    matrices[:, : len(values)], right[:, : len(values)] = base.combination, values
    rows = len(values) + np.arange(lacking)
    matrices[np.arange(len(chosen))[:, None], rows, chosen] = 1.0
    right[:, len(values) :] = known[chosen]
    regular = np.linalg.cond(matrices) < 1e10
    found = np.linalg.solve(matrices[regular], right[regular][..., None])[..., 0]
    positive = np.where(found > 0.0, found, np.nan)
    some = np.isfinite(positive).any(axis=0)
    low, high = (
        np.where(some, limit(np.where(np.isnan(positive), empty, positive), axis=0), np.nan)
        for limit, empty in ((np.min, np.inf), (np.max, -np.inf))
    )
    return Completion(
        total,
        len(chosen),
        int(regular.sum()),
        found.mean(axis=0),
        found.std(axis=0),
        low,
        high,
        _inside(data, low, high, found.mean(axis=0)),
    )


def minimum_norm(data: Regression) -> Floats:
    """Plain least squares of all parameters (p + 2n,): what ignores rank and physics."""
    scale = np.linalg.norm(data.regressor, axis=0)
    scale = np.where(scale > 0.0, scale, 1.0)
    return np.asarray(np.linalg.lstsq(data.regressor / scale, data.force, rcond=1e-9)[0] / scale)


def _inside(data: Regression, low: Floats, high: Floats, mean: Floats) -> Floats:
    """Bounded least squares; a parameter without a positive value keeps its mean."""
    bottom, top = np.where(np.isnan(low), mean, low), np.where(np.isnan(high), mean, high)
    room = np.maximum(top - bottom, 1e-9 * np.maximum(np.abs(top), 1e-9))
    found = scipy.optimize.lsq_linear(
        data.regressor * room, data.force - data.regressor @ bottom, bounds=(0.0, 1.0)
    )
    return np.asarray(bottom + room * found.x)


def _correlated(scaled: Floats, data: Regression) -> Floats:
    """X^T R X (base, base) of rows X: those of an axis are correlated, axes are independent."""
    place = np.rint((data.time - data.time.min()) / data.spacing).astype(int)
    total = np.zeros((scaled.shape[1],) * 2)
    for i in np.unique(data.axis):
        grid = np.zeros((place.max() + 1, scaled.shape[1]))  # rows that are left out stay zero
        grid[place[data.axis == i]] = scaled[data.axis == i]
        total += grid.T @ grid
        for lag, shared in enumerate(data.correlation[1 : len(grid)], start=1):
            once = shared * grid[:-lag].T @ grid[lag:]
            total += once + once.T
    return total


def correlation(data: Regression, left: Floats) -> Floats:
    """Measured correlation (axes,) of residuals (rows,) one spacing apart."""
    place = np.rint((data.time - data.time.min()) / data.spacing).astype(int)
    found = []
    for i in np.unique(data.axis):
        mine, values = place[data.axis == i], left[data.axis == i]
        _, here, there = np.intersect1d(mine + 1, mine, return_indices=True)
        found.append(np.corrcoef(values[here], values[there])[0, 1])
    return np.array(found)


def _scatter(left: Floats, axis: NDArray[np.int64], axes: int) -> Floats:
    return np.array([np.std(left[axis == i]) for i in range(axes)])
