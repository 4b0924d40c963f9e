"""Numbers with intervals: shares of cases, medians, and how far stated probabilities are from the truth."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]
BINS = 10


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """A number with its 95 % interval and the number of cases behind it."""

    value: float
    low: float
    high: float
    n: int


def proportion(hits: Sequence[bool]) -> Estimate:
    """Share of hits with the Wilson interval; nan and [0, 1] for no cases."""
    n, k = len(hits), sum(hits)
    if n == 0:
        return Estimate(value=float("nan"), low=0.0, high=1.0, n=0)
    interval = stats.binomtest(k, n).proportion_ci(method="wilson")
    return Estimate(value=k / n, low=float(interval.low), high=float(interval.high), n=n)


def bootstrapped(
    statistic: Callable[[Array], float], rows: Sequence[Sequence[float]], *, resamples: int = 2000
) -> Estimate:
    """``statistic`` of an (n, columns) array, resampling rows (seeded)."""
    data = np.asarray(rows, dtype=float)
    n = len(data)
    if n == 0:
        return Estimate(value=float("nan"), low=float("nan"), high=float("nan"), n=0)
    rng = np.random.default_rng(0)
    values = [statistic(data[rng.integers(n, size=n)]) for _ in range(resamples)]
    low, high = np.percentile(values, [2.5, 97.5])
    return Estimate(value=statistic(data), low=float(low), high=float(high), n=n)


def calibration_error(confidence_and_right: Array) -> float:
    """Expected calibration error of (n, 2) rows: sum over ten bins of n_b/n |accuracy - confidence|."""
    error = 0.0
    for _, confidence, accuracy, count in reliability(confidence_and_right):
        error += count / len(confidence_and_right) * abs(accuracy - confidence)
    return error


def reliability(confidence_and_right: Array) -> list[tuple[int, float, float, int]]:
    """(bin, mean confidence, accuracy, count) of every bin that holds a case."""
    confidence, right = confidence_and_right.T
    bins = np.minimum((confidence * BINS).astype(int), BINS - 1)
    return [
        (
            int(b),
            float(confidence[bins == b].mean()),
            float(right[bins == b].mean()),
            int(sum(bins == b)),
        )
        for b in np.unique(bins)
    ]


def median(column: Array) -> float:
    """Median of all numbers, for ``bootstrapped``."""
    return float(np.median(column))
