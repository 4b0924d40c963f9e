"""What each of several accepted effects takes off the gap, whatever the order they are added in.

The worth of a set of effects is the mean square it takes off the retuned model's held-out residual.
An effect's share is its Shapley value (Shapley 1953; Owen and Prieur 2017): its mean gain over all
orders. Where a gain depends much on the order, the effects stand in for each other.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations, permutations
from typing import Any

import numpy as np

from .fitting import fit
from .hypothesis import Fit
from .prediction import Predictor


@dataclass(frozen=True, kw_only=True)
class Share:
    """One effect's part of what all accepted effects remove together."""

    effect: str
    share: float  # Shapley value, over that of the whole set
    first: float  # of what it removes when it is added first
    last: float  # of what it removes when it is added last

    def to_json(self) -> dict[str, Any]:
        """Numbers by name."""
        return {"id": self.effect, "share": self.share, "first": self.first, "last": self.last}


def order_shares(
    predictor: Predictor, retuned: Fit, accepted: Fit, known: Sequence[Fit]
) -> list[Share]:
    """Shares of the accepted effects, one entry an effect; ``known`` are fits made before.

    A part of the accepted set that was never fitted is fitted here.
    """
    ids = accepted.hypothesis.ids
    losses: dict[frozenset[str], float] = {}
    for size in range(len(ids) + 1):
        for part in combinations(ids, size):
            losses[frozenset(part)] = _loss(predictor, retuned, accepted, frozenset(part), known)
    return shapley(ids, losses)


def shapley(ids: Sequence[str], losses: Mapping[frozenset[str], float]) -> list[Share]:
    """Shares from the mean square residual of every subset of ``ids``."""
    nothing, everything = frozenset[str](), frozenset(ids)
    whole = losses[nothing] - losses[everything]
    if not whole > 0.0:
        return []
    gains: dict[str, list[float]] = {effect: [] for effect in ids}
    for order in permutations(ids):
        for i, effect in enumerate(order):
            before = frozenset(order[:i])
            gains[effect].append(losses[before] - losses[before | {effect}])
    return [
        Share(
            effect=effect,
            share=float(np.mean(gains[effect])) / whole,
            first=(losses[nothing] - losses[frozenset({effect})]) / whole,
            last=(losses[everything - {effect}] - losses[everything]) / whole,
        )
        for effect in ids
    ]


def _loss(
    predictor: Predictor,
    retuned: Fit,
    accepted: Fit,
    part: frozenset[str],
    known: Sequence[Fit],
) -> float:
    """Mean square held-out residual of a part of the accepted hypothesis, in its own forms."""
    if not part:
        return retuned.held_out_rms**2
    hypothesis = accepted.hypothesis
    if part == frozenset(hypothesis.ids):
        return accepted.held_out_rms**2
    fitted = [f for f in known if frozenset(f.hypothesis.ids) == part and f.converged]
    if fitted:
        return min(f.held_out_rms for f in fitted) ** 2
    for effect in hypothesis.ids:
        if effect not in part:
            hypothesis = hypothesis.without(effect)
    return fit(predictor, hypothesis, accepted, screen=-np.inf).held_out_rms ** 2
