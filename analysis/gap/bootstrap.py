"""Block bootstrap: how sure a number is whose samples depend on their neighbours.

A run is cut into blocks, the blocks are drawn anew with replacement. Künsch, *The jackknife and the bootstrap for
general stationary observations*, Annals of Statistics 17 (1989).
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .machine import Array

LEVEL = 0.95  # of every interval


def energies(values: Sequence[Array], blocks: int) -> tuple[Array, Array]:
    """Sums of squares over ``blocks`` blocks of every run (samples, n), and the number of values in each."""
    pieces = [p for v in values for p in np.array_split(v, min(blocks, len(v)), axis=0)]
    return np.array([np.sum(p**2) for p in pieces]), np.array([float(p.size) for p in pieces])


def draws(blocks: int, resamples: int, random: np.random.Generator) -> NDArray[np.int64]:
    """Blocks (resamples, blocks) drawn with replacement."""
    return random.integers(0, blocks, (resamples, blocks))


def resampled_rms(energy: Array, count: Array, drawn: NDArray[np.int64]) -> Array:
    """Rms (resamples,) of the blocks drawn."""
    return np.asarray(np.sqrt(energy[drawn].sum(axis=1) / count[drawn].sum(axis=1)))


def interval(sampled: Array) -> tuple[Array, Array]:
    """Bounds (...) of the central ``LEVEL`` of resampled values (resamples, ...)."""
    tail = 0.5 * (1.0 - LEVEL)
    low, high = np.quantile(sampled, [tail, 1.0 - tail], axis=0)
    return low, high
