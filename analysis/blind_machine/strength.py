"""How visible an effect is: the change it makes, in multiples of what repeats differ by.

The same machine with the same nuisance and noise is run without the effect. Per signal, the change
is the RMS difference of the two logs and the floor is the RMS difference of the second and third
cycle of the run without it, over sqrt(2) (that is one realisation's share; it holds encoder
counts, the chatter they cause through the controller, and noise). An effect's strength is the RMS
of those ratios over positions and torques. Only runs marked for fitting count: what acts on
validation runs alone may not be used to choose an effect (FORMAT.md), so nobody can name it.
"""

from collections.abc import Sequence

import numpy as np

from .motion import Array

CYCLES = 3


def floor(tables: Sequence[Array], signals: slice) -> Array:
    """Repeatability of each of the columns ``signals``, pooled over the runs, in their units."""
    squares, samples = 0.0, 0
    for table in tables:
        n = len(table) // CYCLES
        gap = table[2 * n : 3 * n, signals] - table[n : 2 * n, signals]
        squares = squares + np.sum(gap**2, axis=0) / 2
        samples += n
    return np.asarray(np.sqrt(squares / samples))


def strength(
    with_effect: Sequence[Array], without: Sequence[Array], runs: Sequence[int], signals: slice
) -> float:
    """Pooled change over pooled floor on ``runs``, root mean square over positions and torques."""
    with_effect, without = [with_effect[i] for i in runs], [without[i] for i in runs]
    gaps = np.concatenate([a[:, signals] - b[:, signals] for a, b in zip(with_effect, without)])
    change = np.sqrt(np.mean(gaps**2, axis=0))
    return float(np.sqrt(np.mean((change / floor(without, signals)) ** 2)))


def gap(
    logged: Sequence[Array], model: Sequence[Array], runs: Sequence[int], signals: slice
) -> float:
    """Log minus model on ``runs`` in multiples of the log's own floor there, pooled as above."""
    mine, theirs = [logged[i] for i in runs], [model[i] for i in runs]
    gaps = np.concatenate([a[:, signals] - b[:, signals] for a, b in zip(mine, theirs)])
    return float(np.sqrt(np.mean(np.mean(gaps**2, axis=0) / floor(mine, signals) ** 2)))
