"""A floor from stretches of a run whose references repeat earlier ones, of whatever period.

Runs of an arm seldom repeat from end to end, but parts of them do. Two stretches are the same motion where
the references of all joints stay within ``SAME`` of each other for ``SHORTEST`` samples and more and one
joint moves at least. Half the squared difference of their residuals is the floor. Stretches
at rest prove nothing: friction holds a joint wherever it was left.
"""

from collections.abc import Sequence

import numpy as np

from ..floor import NO_CYCLES
from ..machine import Array, RunData

SAME = 1e-3  # of the references' largest range, or the encoder's step if that is larger
SHORTEST = 20  # samples of a stretch
MOVES = 20.0  # multiples of ``SAME`` that a joint must move in a stretch


def repeats(reference: Array, same: float) -> list[tuple[slice, int]]:
    """Stretches of a reference (samples, n) that repeat earlier ones, with how many samples earlier.

    Every sample is in one stretch at most, the longest that it is in.
    """
    found = []
    for lag in range(SHORTEST, len(reference) - SHORTEST):
        alike = np.all(np.abs(reference[lag:] - reference[:-lag]) <= same, axis=1)
        if np.count_nonzero(alike) < SHORTEST:
            continue
        edges = np.flatnonzero(np.diff(np.concatenate([[0], alike.astype(int), [0]])))
        for start, stop in zip(edges[::2], edges[1::2]):
            if stop - start >= SHORTEST:
                found.append((int(start) + lag, int(stop) + lag, lag))
    taken = np.zeros(len(reference), dtype=bool)
    kept = []
    for start, stop, lag in sorted(found, key=lambda f: (f[0] - f[1], f[2])):
        for a, b in _free(taken, start, stop):
            moves = np.max(np.ptp(reference[a:b], axis=0))
            if b - a >= SHORTEST and moves > MOVES * same:
                taken[a:b] = True
                kept.append((slice(a, b), lag))
    return kept


def repeated_floor(runs: Sequence[RunData], residuals: Sequence[Array]) -> tuple[list[Array], str]:
    """Floor samples (k, n) of every run and how they were found.

    A run without repeated stretches has the floor of the others. It is never below the encoder's
    quantisation, which alone is the floor where no run has any.
    """
    floors: list[Array | None] = []
    for run, residual in zip(runs, residuals):
        reference = run.reference[run.window]
        same = max(SAME * float(np.max(np.ptp(reference, axis=0))), run.lsb, 1e-9)
        parts = [
            (residual[s] - residual[s.start - lag : s.stop - lag]) / np.sqrt(2.0)
            for s, lag in repeats(reference, same)
        ]
        floors.append(np.concatenate(parts) if parts else None)
    step = max(run.lsb for run in runs) / np.sqrt(12.0)
    encoder = [np.full_like(r, step) for r in residuals]
    seen = [floor for floor in floors if floor is not None]
    if not seen:
        return encoder, f"encoder resolution; {NO_CYCLES}"
    pooled = np.concatenate(seen)
    if np.sqrt(np.mean(pooled**2)) < step:
        return encoder, "encoder resolution, which exceeds the repeatability"
    source = f"stretches of motion that repeat, {len(pooled)} samples in {len(seen)} runs"
    return [pooled if floor is None else floor for floor in floors], source


def _free(taken: Array, start: int, stop: int) -> list[tuple[int, int]]:
    """Parts of [start, stop) that are not taken."""
    edges = np.flatnonzero(np.diff(np.concatenate([[1], taken[start:stop].astype(int), [1]])))
    return [(start + int(a), start + int(b)) for a, b in zip(edges[::2], edges[1::2])]
