"""How sure the choice is: held-out losses of every hypothesis, resampled by blocks.

How often a hypothesis wins when the blocks are drawn anew is its probability.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from . import bootstrap
from .hypothesis import Fit, price, price_of
from .machine import Array

RESAMPLES = 1000
LATE_TWIN = 0.02  # scores of a delay and a lag this close are not told apart
TWIN = 0.002  # scores closer than this share of the residual separate nothing: nuisance exceeds it


@dataclass(frozen=True, kw_only=True)
class Ranked:
    """A hypothesis in the ranking."""

    fit: Fit
    probability: float
    gain: float  # fall of the log held-out residual against the retuned nominal
    gain_interval: tuple[float, float]  # 95 %, block bootstrap


def best_by_ids(fits: Sequence[Fit]) -> list[Fit]:
    """The best form of every set of effects."""
    best: dict[frozenset[str], Fit] = {}
    for candidate in fits:
        ids = frozenset(candidate.hypothesis.ids)
        if ids not in best or candidate.score < best[ids].score:
            best[ids] = candidate
    return list(best.values())


def rank(fits: Sequence[Fit], retuned: Fit, seed: int) -> list[Ranked]:
    """Best first, with bootstrap probabilities and gains over the retuned nominal."""
    chosen = best_by_ids(fits)
    losses = _shared_losses(chosen)
    prices = np.array([_fair_price(f, chosen) for f in chosen])
    samples = retuned.samples
    drawn = bootstrap.draws(samples.size, RESAMPLES, np.random.default_rng(seed))
    logs = np.log([bootstrap.resampled_rms(row, samples, drawn) for row in losses])
    wins = _shared_wins(_best_of_twins(logs + prices[:, None], _late_groups(chosen), chosen))
    reference = np.log(bootstrap.resampled_rms(retuned.losses, samples, drawn))
    ranked = []
    for i, candidate in enumerate(chosen):
        low, high = bootstrap.interval(reference - logs[i])
        ranked.append(
            Ranked(
                fit=candidate,
                probability=float((wins[i] + 1.0 / len(chosen)) / (RESAMPLES + 1.0)),
                gain=float(
                    np.log(retuned.held_out_rms) - 0.5 * np.log(losses[i].sum() / samples.sum())
                ),
                gain_interval=(float(low), float(high)),
            )
        )
    scores = 0.5 * np.log(losses.sum(axis=1) / samples.sum()) + prices
    # Twins have one score; which of them fits better says a little of which it is.
    shared = _best_of_twins(scores[:, None], _late_groups(chosen), chosen)[:, 0]
    order = np.lexsort((np.array([f.rms for f in chosen]), shared))
    return [ranked[i] for i in order]


def _shared_losses(fits: Sequence[Fit]) -> Array:
    """Held-out losses (hypotheses, blocks); hypotheses with the same predictions have the same.

    Which of them predicts held-out runs better is chance: they left other directions free.
    """
    losses = np.array([f.losses for f in fits])
    shared = losses.copy()
    for i, f in enumerate(fits):
        for j, other in enumerate(fits):
            if losses[j].sum() < shared[i].sum() and _same_predictions(f, other):
                shared[i] = losses[j]
    return shared


def _fair_price(candidate: Fit, fits: Sequence[Fit]) -> float:
    """Price of a hypothesis, its effects priced as in the cheapest of the same predictions.

    A form of friction with one parameter more than its rival's must not decide between a gain and a scale.
    """
    mine = candidate.hypothesis
    twins = [
        f.hypothesis
        for f in fits
        if len(f.hypothesis.ids) == len(mine.ids) and _same_predictions(candidate, f)
    ]
    saved = sum(
        max(price_of(mine, e) - price_of(twin, e) for twin in (mine, *twins) if e in twin.ids)
        for e in mine.ids
    )
    return price(mine) - saved


def _late_groups(fits: Sequence[Fit]) -> list[frozenset[str]]:
    """For every hypothesis its effects, with delay and lag called by one name."""
    return [
        frozenset("late" if form.shifts else form.effect for form in f.hypothesis.forms)
        for f in fits
    ]


def _best_of_twins(scores: Array, groups: Sequence[frozenset[str]], fits: Sequence[Fit]) -> Array:
    """Scores (hypotheses, draws) with those of twins replaced by those of the best among them.

    A delay and a lag are twins where either would do: within ``LATE_TWIN``, and beside impacts always, where the
    searches for the two end in different optima and which is better is chance.
    """
    shared = scores.copy()
    means = scores.mean(axis=1)
    for i, group in enumerate(groups):
        twins = [
            j
            for j, other in enumerate(groups)
            if other == group and (fits[i].hypothesis.rough or abs(means[j] - means[i]) < LATE_TWIN)
        ]
        shared[i] = scores[min(twins, key=lambda j: float(means[j]))]
    return shared


def _same_predictions(a: Fit, b: Fit) -> bool:
    """Whether what the residuals differ by changes the log residual by less than ``TWIN``."""
    if a.residual.size == 0 or a.residual.size != b.residual.size:
        return False
    return float(np.mean((a.residual - b.residual) ** 2)) < 2.0 * TWIN * b.rms**2


def _shared_wins(scores: Array) -> Array:
    """Draws won by each hypothesis of ``scores`` (hypotheses, draws); twins share theirs."""
    close = scores <= scores.min(axis=0) + TWIN
    return np.asarray((close / close.sum(axis=0)).sum(axis=1))
