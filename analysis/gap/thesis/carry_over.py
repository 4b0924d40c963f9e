"""Does a hypothesis fitted at 2 Hz predict the 1 Hz table, which was never used to fit or to choose?"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..hypothesis import Fit
from ..machine import Array
from .experiment import METRICS, TESTS, repeatability
from .fitting import TableFitter

RESAMPLES = 100


@dataclass(frozen=True, kw_only=True)
class CarryOver:
    """Rms relative errors on the held-out table and the share of the gap that is removed."""

    before: float  # nominal model
    retuned: float
    after: float
    floor: float  # between replicate tests of the held-out table
    percent: float | None  # None where nothing is above the floor
    ci95: tuple[float, float] | None
    by_metric: dict[str, tuple[float, float]]  # before and after
    by_motion: dict[str, tuple[float, float]]
    by_controller: dict[str, tuple[float, float]]


def carry_over(
    fitted_to: TableFitter,
    held_out: TableFitter,
    nominal: Fit,
    retuned: Fit,
    chosen: Fit,
    seed: int,
) -> CarryOver:
    """Errors on the held-out table; the interval resamples the tests of both tables."""
    before, tuned, after = (held_out.errors(f) for f in (nominal, retuned, chosen))
    floor = repeatability(held_out.experiment)
    top = _rms(before)
    percent = 100.0 * (top - _rms(after)) / (top - floor) if top > 1.05 * floor else None
    interval = _interval(fitted_to, held_out, before, chosen, floor, seed) if percent else None
    motions = dict.fromkeys(motion for _, motion in TESTS)
    controllers = dict.fromkeys(name for name, _ in TESTS)
    return CarryOver(
        before=top,
        retuned=_rms(tuned),
        after=_rms(after),
        floor=floor,
        percent=percent,
        ci95=interval,
        by_metric={m: (_rms(before[:, i]), _rms(after[:, i])) for i, m in enumerate(METRICS)},
        by_motion={m: _pair(before, after, 1, m) for m in motions},
        by_controller={c: _pair(before, after, 0, c) for c in controllers},
    )


def _interval(
    fitted_to: TableFitter,
    held_out: TableFitter,
    before: Array,
    chosen: Fit,
    floor: float,
    seed: int,
) -> tuple[float, float]:
    rng = np.random.default_rng(seed)
    tests = len(TESTS)
    drawn = rng.integers(0, tests, (RESAMPLES, tests))
    weights = [np.bincount(row, minlength=tests).astype(float) for row in drawn]
    refitted = fitted_to.reweighted(chosen, weights)
    errors = held_out.errors_of(refitted)
    shares = []
    for after, row in zip(errors, rng.integers(0, tests, (RESAMPLES, tests))):
        top = _rms(before[row])
        shares.append(100.0 * (top - _rms(after[row])) / max(top - floor, 1e-12))
    low, high = np.quantile(shares, [0.025, 0.975])
    return float(low), float(high)


def parameter_intervals(
    fitter: TableFitter, chosen: Fit, seed: int
) -> dict[tuple[str, str], tuple[float, float]]:
    """95 % intervals of the parameters when the tests of the fitted table are resampled."""
    rng = np.random.default_rng(seed)
    tests = len(TESTS)
    weights = [
        np.bincount(rng.integers(0, tests, tests), minlength=tests).astype(float)
        for _ in range(RESAMPLES)
    ]
    values = np.array([f.values for f in fitter.reweighted(chosen, weights)])
    if not chosen.keys:
        return {}
    low, high = np.quantile(values, [0.025, 0.975], axis=0)
    return {key: (float(a), float(b)) for key, a, b in zip(chosen.keys, low, high)}


def _pair(before: Array, after: Array, place: int, name: str) -> tuple[float, float]:
    rows: Sequence[int] = [i for i, test in enumerate(TESTS) if test[place] == name]
    return _rms(before[rows]), _rms(after[rows])


def _rms(errors: Array) -> float:
    return float(np.sqrt(np.mean(errors**2)))
