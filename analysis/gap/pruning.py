"""Dropping the parameters that the data do not need, and where the search without them begins."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from .fitting import fit
from .hypothesis import Fit
from .prediction import Predictor
from .search import linear_step

IDLE = 1e-3  # a parameter whose loss rises by less than this without it goes at once

# A place goes too, whatever the score says, where what it adds is slight in both ways: small errors of the model
# beside a large effect make such a place significant.
SLIGHT = 2e-2  # relative rise of the loss without it: 1 % of the residual
SHARE = 1e-3  # of the rise without the effect's most important parameter: 3 % in amplitude

Key = tuple[str, str]  # (effect, parameter)


def pruned(predictor: Predictor, full: Fit) -> Fit:
    """Drop removable parameters, least important first, while the score does not get worse."""
    current = full
    while True:
        candidates = _removable(current)
        if not candidates:
            return current
        one = [min(candidates)[1]]
        if _slight(current, min(candidates)):
            current = _without(predictor, current, one)
            continue
        for gone in (_idle(candidates), one):
            trial = _without(predictor, current, gone)
            if trial.score <= current.score or gone == one:
                break
        if trial.score > current.score:
            return current
        current = trial


def _slight(current: Fit, candidate: tuple[float, Key]) -> bool:
    """Whether a parameter adds next to nothing, to the fit and to its effect."""
    importance, (effect, _) = candidate
    largest = max(i for i, key in zip(current.importance, current.keys) if key[0] == effect)
    return bool(importance < min(SLIGHT, SHARE * largest))


def _removable(current: Fit) -> list[tuple[float, Key]]:
    """Importance and key of each parameter that may go."""
    names = {(form.effect, name) for form in current.hypothesis.forms for name in form.removable}
    found = [(i, key) for i, key in zip(current.importance, current.keys) if key in names]
    return [c for c in found if _may_go(c[1], found)]


def _idle(candidates: list[tuple[float, Key]]) -> list[Key]:
    """The least important parameter and all others that count for nothing."""
    ordered = sorted(candidates)
    gone = [ordered[0][1]]
    for importance, key in ordered[1:]:
        left = [c for c in candidates if c[1] not in gone]
        if importance < IDLE and _may_go(key, left):
            gone.append(key)
    return gone


def _may_go(key: Key, candidates: list[tuple[float, Key]]) -> bool:
    """Whether its effect would keep another removable parameter."""
    return any(other[0] == key[0] and other != key for _, other in candidates)


def _without(predictor: Predictor, current: Fit, gone: Collection[Key]) -> Fit:
    """The fit without some parameters, searched from where the linearised loss without them is least.

    Parameters that balance each other are large together: dropping one alone would start far away.
    """
    smaller = current.hypothesis
    for key in gone:
        smaller = smaller.drop(key)
    return fit(predictor, smaller, _balanced(predictor, current, gone))


def _balanced(predictor: Predictor, current: Fit, gone: Collection[Key]) -> Fit:
    if current.jacobian.size == 0 or current.hypothesis.rough:
        return current
    parameters = [p for _, p in current.hypothesis.free(predictor.machine)]
    scale, lower, upper = (
        np.array([getattr(p, name) for p in parameters]) for name in ("scale", "lower", "upper")
    )
    x = current.values / scale
    left = np.array([key not in gone for key in current.keys])
    residual = current.residual - current.jacobian[:, ~left] @ x[~left]
    bounds = (lower / scale)[left], (upper / scale)[left]
    x[left] += linear_step(current.jacobian[:, left], residual, x[left], bounds)
    return replace(current, values=x * scale)
