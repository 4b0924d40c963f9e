"""Which effects: fit every hypothesis, grow the best ones, and say how sure the choice is.

Every single effect is fitted in each of its forms, scored on held-out runs, pruned of parameters
that the data do not need, and grown by forward selection while a further effect pays. How often a
hypothesis wins when the blocks of the held-out losses are resampled is its probability.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .effects import Form
from .fitting import FIRST_STEPS, SCREEN, Predictor, fit
from .hypothesis import Fit, Hypothesis, price
from .machine import Array

MOST_EFFECTS = 3
BEAM = 2  # single effects that a second one is added to
LEAST_GAIN = 0.02  # smallest fall of the score worth another effect or another set of them
FURTHER_SCREEN = 0.08  # a further effect must lower the loss by more; its price alone asks for 0.18
NEAR_FLOOR = 1.03  # a residual this close to the floor, as a ratio, leaves nothing to explain
DONE = 1.1  # nor does one this close call for a richer form of another effect
IDLE = 1e-3  # a parameter whose loss rises by less than this without it goes at once
PROMISE = 0.25  # of the fall of a sibling's loss, asked of the start of a search for impacts
CONTENDER = 1.5  # a search goes on while its residual is within this ratio of the best one's
RESAMPLES = 1000
TWIN = 0.002  # scores closer than this share of the residual separate nothing: nuisance exceeds it

Progress = Callable[[str], None]


@dataclass(frozen=True, kw_only=True)
class Ranked:
    """A hypothesis in the ranking."""

    fit: Fit
    probability: float
    gain: float  # fall of the log held-out residual against the retuned nominal
    gain_interval: tuple[float, float]  # 95 %, block bootstrap


def attribute(
    predictor: Predictor,
    retuned: Fit,
    forms: Sequence[Form],
    floor: float,
    seed: int,
    progress: Progress,
) -> list[Ranked]:
    """Every hypothesis that was tried, best first; ``floor`` in the unit of the residual."""
    plain = [form for form in forms if not form.refined]
    refined = [form for form in forms if form.refined]
    singles = _add_each(predictor, retuned, plain, progress)
    singles = [_pruned(predictor, f) for f in _best_by_ids(singles)]
    fits = [retuned, *singles]
    parents = _beam([f for f in sorted(singles, key=lambda f: f.score) if _better(f, retuned)])
    best = parents[0] if parents else retuned
    while parents:
        # Impacts leave a residual too rough to tell a further effect from a better optimum.
        if best.held_out_rms < NEAR_FLOOR * floor or best.hypothesis.rough:
            break
        children = _grown(predictor, parents, plain, fits, progress)
        if not children:
            break
        child = _pruned(predictor, children[0])
        smaller = _without_each(predictor, child)
        fits += [child, *children[1:], *smaller]
        found = min([child, *smaller], key=lambda f: f.score)
        if best.score - found.score < LEAST_GAIN:
            break
        before = {frozenset(p.hypothesis.ids) for p in parents}
        best = found
        # What the new effect made needless, or look different, may have another partner.
        parents = [best] + [
            f for f in smaller if f is not best and frozenset(f.hypothesis.ids) not in before
        ]
    for form in refined:
        if form.effect not in best.hypothesis.ids and best.held_out_rms < DONE * floor:
            continue
        progress(f"{form.effect}, {form.name}")
        fits.append(_pruned(predictor, _refine(predictor, best, retuned, form)))
    return rank([f for f in fits if f.converged], retuned, seed)


def _beam(singles: Sequence[Fit]) -> list[Fit]:
    """The best few of some fits, best first, no two of one family: those differ too little."""
    chosen: list[Fit] = []
    for candidate in singles:
        families = {f.hypothesis.forms[0].family for f in chosen} - {""}
        if candidate.hypothesis.forms[0].family not in families and len(chosen) < BEAM:
            chosen.append(candidate)
    return chosen


def _better(candidate: Fit, retuned: Fit) -> bool:
    return candidate.converged and retuned.score - candidate.score > LEAST_GAIN


def _add_each(
    predictor: Predictor, parent: Fit, forms: Sequence[Form], progress: Progress
) -> list[Fit]:
    """The parent with each further form that can act beside its own."""
    children: list[Fit] = []
    families = {form.family for form in parent.hypothesis.forms if form.family}
    for form in forms:
        if form.effect in parent.hypothesis.ids or form.family in families:
            continue
        progress(f"{parent.hypothesis.label} + {form.effect}, {form.name}")
        same = [f for f in children if f.hypothesis.ids[-1] == form.effect and not form.own_start]
        warm = min(same, key=lambda f: f.score) if same else parent
        child = parent.hypothesis.with_form(form)
        screen = FURTHER_SCREEN if parent.hypothesis.forms else SCREEN
        if child.rough:  # its start must promise a part of what a sibling reached
            reached = min((f.rms for f in children if f.hypothesis.rough), default=parent.rms)
            screen = max(screen, PROMISE * (1.0 - (reached / parent.rms) ** 2))
        children.append(fit(predictor, child, warm, screen, FIRST_STEPS))
    return _taken_further(predictor, children)


def _taken_further(predictor: Predictor, fits: Sequence[Fit]) -> list[Fit]:
    """The fits, those searched on that did not end and are not far behind the best."""
    best = min((f.rms for f in fits), default=0.0)
    return [
        f if f.finished or f.rms > CONTENDER * best else fit(predictor, f.hypothesis, f)
        for f in fits
    ]


def _grown(
    predictor: Predictor,
    parents: Sequence[Fit],
    forms: Sequence[Form],
    tried: Sequence[Fit],
    progress: Progress,
) -> list[Fit]:
    """The parents with one effect more each, best first, sets of effects not tried before."""
    known = {frozenset(f.hypothesis.ids) for f in tried}
    smooth = [p for p in parents if not p.hypothesis.rough]
    children = [
        child
        for parent in smooth
        if len(parent.hypothesis.forms) < MOST_EFFECTS
        for child in _add_each(
            predictor,
            parent,
            [
                f
                for f in forms
                if frozenset((*parent.hypothesis.ids, f.effect)) not in known
                and (
                    f.step == 0.0 or parent is parents[0]
                )  # impacts are dear: beside the best only
            ],
            progress,
        )
    ]
    return sorted(_best_by_ids(children), key=lambda f: f.score)


def _without_each(predictor: Predictor, full: Fit) -> list[Fit]:
    """The fit without each of its effects in turn, searched from where the whole one ended."""
    if len(full.hypothesis.forms) < 2:
        return []
    return [
        fit(predictor, full.hypothesis.without(effect), full, screen=-np.inf)
        for effect in full.hypothesis.ids
    ]


def _refine(predictor: Predictor, best: Fit, retuned: Fit, form: Form) -> Fit:
    """The best hypothesis with its form of this effect made richer, or the richer form alone."""
    if form.effect in best.hypothesis.ids:
        others = best.hypothesis
        for effect in (form.effect, *form.stands_for):
            others = others.without(effect)
        return fit(predictor, others.with_form(form), best)
    return fit(predictor, Hypothesis(forms=(form,)), retuned)


def _pruned(predictor: Predictor, full: Fit) -> Fit:
    """Drop removable parameters, least important first, while the score does not get worse."""
    current = full
    while True:
        removable = {
            (form.effect, name) for form in current.hypothesis.forms for name in form.removable
        }
        candidates = [
            (importance, key)
            for importance, key in zip(current.importance, current.keys)
            if key in removable
        ]
        candidates = [c for c in candidates if _may_go(c[1], candidates)]
        if not candidates:
            return current
        smaller = current.hypothesis.drop(min(candidates)[1])
        for importance, key in sorted(candidates)[1:]:
            left = [c for c in candidates if (c[1] not in smaller.dropped)]
            if importance < IDLE and _may_go(key, left):
                smaller = smaller.drop(key)
        trial = fit(predictor, smaller, current)
        if trial.score > current.score:
            return current
        current = trial


def _may_go(key: tuple[str, str], candidates: Sequence[tuple[float, tuple[str, str]]]) -> bool:
    """Whether its effect would keep another removable parameter."""
    return any(other[0] == key[0] and other != key for _, other in candidates)


def _best_by_ids(fits: Sequence[Fit]) -> list[Fit]:
    """The best form of every set of effects."""
    best: dict[frozenset[str], Fit] = {}
    for candidate in fits:
        ids = frozenset(candidate.hypothesis.ids)
        if ids not in best or candidate.score < best[ids].score:
            best[ids] = candidate
    return list(best.values())


def rank(fits: Sequence[Fit], retuned: Fit, seed: int) -> list[Ranked]:
    """Best first, with bootstrap probabilities and gains over the retuned nominal."""
    chosen = _best_by_ids(fits)
    losses = _shared_losses(chosen)
    prices = np.array([price(f.hypothesis) for f in chosen])
    samples = retuned.samples
    rng = np.random.default_rng(seed)
    draws = rng.integers(0, samples.size, (RESAMPLES, samples.size))
    logs = _log_rms(losses, samples, draws)
    wins = _shared_wins(logs + prices[:, None])
    reference = _log_rms(retuned.losses[None], samples, draws)[0]
    ranked = []
    for i, candidate in enumerate(chosen):
        low, high = np.quantile(reference - logs[i], [0.025, 0.975])
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
    order = np.argsort(scores, kind="stable")
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


def _same_predictions(a: Fit, b: Fit) -> bool:
    """Whether what the residuals differ by changes the log residual by less than ``TWIN``."""
    if a.residual.size == 0 or a.residual.size != b.residual.size:
        return False
    return float(np.mean((a.residual - b.residual) ** 2)) < 2.0 * TWIN * b.rms**2


def _shared_wins(scores: Array) -> Array:
    """Draws won by each hypothesis of ``scores`` (hypotheses, draws); twins share theirs."""
    close = scores <= scores.min(axis=0) + TWIN
    return np.asarray((close / close.sum(axis=0)).sum(axis=1))


def _log_rms(losses: Array, samples: Array, draws: NDArray[np.int64]) -> Array:
    """Log rms (hypotheses, draws) of resampled blocks."""
    count = samples[draws].sum(axis=1)
    return np.array([0.5 * np.log(row[draws].sum(axis=1) / count) for row in losses])
