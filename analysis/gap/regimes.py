"""Ways to sort the samples of a run: each gives every sample of every joint one of a few names.

``locate`` shares the gap out by each of them. All follow the reference, which knows no noise, but for
the load, which is the logged command.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .machine import Array, RunData

LEVELS = (0.1, 0.5)  # of the largest value: slow, middle, fast
LEVEL_NAMES = ("below 10 %", "10 to 50 %", "above 50 %")
REVERSALS_S = (0.01, 0.05, 0.2)  # since the last reversal
FIFTHS = ("first fifth", "second fifth", "third fifth", "fourth fifth", "last fifth")
AT_REST = 1e-3  # of the largest speed

Labels = NDArray[np.int64]


@dataclass(frozen=True, kw_only=True)
class Sorting:
    """One way to sort samples: ``labels`` of a run (samples, n) are numbers of ``names``."""

    key: str
    names: tuple[str, ...]
    labels: Callable[[Sequence[RunData], RunData], Labels]


def peak(runs: Sequence[RunData], signal: str) -> float:
    """Largest magnitude of a signal over some runs."""
    return max(float(np.max(np.abs(getattr(run, signal)))) for run in runs) or 1.0


def since_reversal(rate: Array, dt: float) -> Array:
    """Time since each column last changed sign [s]; inf before the first change."""
    since = np.full_like(rate, np.inf)
    for j in range(rate.shape[1]):
        sign = np.sign(rate[:, j])
        changes = np.flatnonzero(np.diff(sign) != 0) + 1
        if changes.size:
            index = np.searchsorted(changes, np.arange(len(rate)), side="right") - 1
            known = index >= 0
            since[known, j] = dt * (np.arange(len(rate))[known] - changes[index[known]])
    return since


def _level(signal: str) -> Callable[[Sequence[RunData], RunData], Labels]:
    def labels(runs: Sequence[RunData], run: RunData) -> Labels:
        share = np.abs(getattr(run, signal)) / peak(runs, signal)
        return np.digitize(share, LEVELS)

    return labels


def _direction(runs: Sequence[RunData], run: RunData) -> Labels:
    rest = AT_REST * peak(runs, "reference_rate")
    return np.digitize(run.reference_rate, (-rest, rest))


def _reversal(runs: Sequence[RunData], run: RunData) -> Labels:
    return np.digitize(since_reversal(run.reference_rate, run.dt), REVERSALS_S)


def _position(runs: Sequence[RunData], run: RunData) -> Labels:
    low = np.min([r.reference.min(axis=0) for r in runs], axis=0)
    high = np.max([r.reference.max(axis=0) for r in runs], axis=0)
    share = (run.reference - low) / np.maximum(high - low, 1e-300)
    return np.clip((5.0 * share).astype(np.int64), 0, 4)


def _time(runs: Sequence[RunData], run: RunData) -> Labels:
    fifth = 5 * np.arange(len(run.t)) // len(run.t)
    return np.repeat(fifth[:, None], run.position.shape[1], axis=1)


SORTINGS = (
    Sorting(key="directions", names=("backward", "at rest", "forward"), labels=_direction),
    Sorting(key="speeds", names=LEVEL_NAMES, labels=_level("reference_rate")),
    Sorting(key="accelerations", names=LEVEL_NAMES, labels=_level("reference_acceleration")),
    Sorting(
        key="since_reversal",
        names=("under 10 ms", "10 to 50 ms", "50 to 200 ms", "later, or before the first"),
        labels=_reversal,
    ),
    Sorting(key="positions", names=tuple(f"{f} of the travel" for f in FIFTHS), labels=_position),
    Sorting(key="loads", names=LEVEL_NAMES, labels=_level("command")),
    Sorting(key="times", names=tuple(f"{f} of each run" for f in FIFTHS), labels=_time),
)
