"""Representative stretches of a table too long to be fitted whole, chosen by a stated rule.

The table is streamed once in windows of LENGTH rows. A window is described by mean, spread, rms rate and
peak of every column, and by its place in the log. Windows with a gap, an uneven clock or a number that is
not finite are passed over and counted. Chosen are the first and the last usable window - what drifts
shows between them - and then, one by one, the window that differs most from all chosen ones (farthest-
point sampling, Gonzalez 1985), so that rare regimes come before the hundredth repetition of a common one.
"""

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

LONGEST = 250_000  # rows of a run that is read whole
LENGTH = 5_000  # rows of a stretch
COUNT = 10  # stretches of a run


@dataclass(frozen=True, kw_only=True)
class Survey:
    """Windows of a long table."""

    features: Array  # (windows, features); NaN for windows that cannot be used
    rows: int
    first: float  # time of the first row [s]
    last: float

    def describe(self, chosen: Sequence[int]) -> str:
        """The rule and what it left out, in words."""
        unusable = int(np.sum(~np.isfinite(self.features).all(axis=1)))
        passed = (
            f" {unusable} of {len(self.features)} windows were passed over: a gap, an uneven clock "
            "or numbers that are not finite."
            if unusable
            else ""
        )
        return (
            f"{self.rows} rows over {self.last - self.first:.6g} s are too many to fit: "
            f"{len(chosen)} stretches of {LENGTH} rows ({100 * len(chosen) * LENGTH / self.rows:.2g} % of "
            "the log) stand for it, the first, the last and those that differ most in mean, spread, rate "
            f"and peak of the columns. Every row was read; what happens between the stretches is not judged.{passed}"
        )


def survey(stream: Iterable[Array], clock: int, dt: float, limit: float) -> Survey:
    """Describe all whole windows of a stream of blocks (rows, columns).

    ``clock`` is the column of times [s], ``dt`` the stated interval [s], ``limit`` the largest deviation
    of an interval from it, in intervals.
    """
    features: list[Array] = []
    rest: Array | None = None
    rows, first, last = 0, np.nan, np.nan
    for block in stream:
        if not rows and len(block):
            first = float(block[0, clock])
        if len(block):
            rows, last = rows + len(block), float(block[-1, clock])
        values = block if rest is None else np.concatenate([rest, block])
        whole = len(values) // LENGTH * LENGTH
        windows = values[:whole].reshape(-1, LENGTH, values.shape[1])
        features.extend(_features(window, clock, dt, limit) for window in windows)
        rest = values[whole:].copy()
    table = np.array(features)
    place = np.linspace(0.0, 1.0, len(table))[:, None]
    return Survey(features=np.hstack([table, place]), rows=rows, first=first, last=last)


def _features(window: Array, clock: int, dt: float, limit: float) -> Array:
    """Mean, spread, rms rate and peak of each column but the clock; NaN where it cannot be used."""
    steps = np.diff(window[:, clock])
    signals = np.delete(window, clock, axis=1)
    # Written so that NaN, too, makes a window unusable.
    if not (np.all(np.abs(steps - dt) <= limit * dt) and np.isfinite(signals).all()):
        return np.full(4 * signals.shape[1], np.nan)
    mean, spread = signals.mean(axis=0), signals.std(axis=0)
    rate = np.sqrt(np.mean(np.diff(signals, axis=0) ** 2, axis=0))
    return np.concatenate([mean, spread, rate, np.max(np.abs(signals - mean), axis=0)])


def choose(found: Survey) -> list[int]:
    """Indices of at most COUNT windows, in the order of time; empty if none can be used."""
    usable = np.flatnonzero(np.isfinite(found.features).all(axis=1))
    if usable.size <= COUNT:
        return [int(i) for i in usable]
    points = found.features[usable]
    size = points.std(axis=0)
    points = points[:, size > 0.0] / size[size > 0.0]
    chosen = [0, usable.size - 1]
    distance = np.min([np.linalg.norm(points - points[i], axis=1) for i in chosen], axis=0)
    while len(chosen) < COUNT:
        farthest = int(np.argmax(distance))
        chosen.append(farthest)
        distance = np.minimum(distance, np.linalg.norm(points - points[farthest], axis=1))
    return sorted({int(usable[i]) for i in chosen})


def collect(stream: Iterable[Array], chosen: Sequence[int]) -> Iterator[Array]:
    """The rows (LENGTH, columns) of the chosen windows, from a second pass over the same stream."""
    wanted = list(chosen)
    parts: list[Array] = []
    row = 0
    for block in stream:
        while wanted:
            begin = wanted[0] * LENGTH
            low, high = max(begin - row, 0), min(begin + LENGTH - row, len(block))
            if low < high:
                parts.append(block[low:high].copy())
            if begin + LENGTH > row + len(block):
                break
            yield np.concatenate(parts)
            parts = []
            wanted.pop(0)
        row += len(block)
        if not wanted:
            return
