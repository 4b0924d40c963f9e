"""Hypotheses with one effect more or less, searched from where their parents ended."""

from collections.abc import Callable, Sequence

import numpy as np

from .effects import Form
from .fitting import FIRST_STEPS, SCREEN, fit
from .hypothesis import Fit
from .prediction import Predictor
from .ranking import best_by_ids
from .scan import Spectra

MOST_EFFECTS = 3
FURTHER_SCREEN = 0.08  # a further effect must lower the loss by more; its price alone asks for 0.18
PROMISE = 0.25  # of the fall of a sibling's loss, asked of the start of a search for impacts
CONTENDER = 1.5  # a search goes on while its residual is within this ratio of the best one's

Progress = Callable[[str], None]


def with_each(
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
    further = []
    for f in fits:
        screen = -np.inf if f.hypothesis.rough else SCREEN
        # Held-out parameters are one step further, and may be far better, where a search has just begun.
        over = f.finished or min(f.rms, f.held_out_rms) > CONTENDER * best
        further.append(f if over else fit(predictor, f.hypothesis, f, screen))
    return further


def grown(
    predictor: Predictor,
    parents: Sequence[Fit],
    forms: Sequence[Form],
    spectra: Spectra,
    tried: Sequence[Fit],
    progress: Progress,
) -> list[Fit]:
    """The parents with one effect more each, best first, sets of effects not tried before.

    The first parent is joined by what ``spectra`` find beside it, too.
    """
    known = {frozenset(f.hypothesis.ids) for f in tried}
    smooth = [p for p in parents if not p.hypothesis.rough]
    # Impacts are dear: beside the best only, not where impacts themselves are far better, and then in their form.
    best = min(parents, key=lambda p: p.rms, default=None)
    beside_impacts = smooth[0] if smooth and best and smooth[0].rms < CONTENDER * best.rms else None
    known_impacts = [f for p in parents for f in p.hypothesis.forms if f.step > 0.0]
    children = [
        child
        for parent in smooth
        if len(parent.hypothesis.forms) < MOST_EFFECTS
        for child in with_each(
            predictor,
            parent,
            [
                f
                for f in [*forms, *(spectra.forms_beside(parent) if parent is parents[0] else [])]
                if frozenset((*parent.hypothesis.ids, f.effect)) not in known
                and (f.step == 0.0 or parent is beside_impacts)
                and (f.step == 0.0 or f in known_impacts or not known_impacts)
            ],
            progress,
        )
    ]
    return sorted(best_by_ids(children), key=lambda f: f.score)


def from_other_sides(predictor: Predictor, child: Fit, tried: Sequence[Fit]) -> list[Fit]:
    """The same effects, searched from where each fit with one of them less has ended.

    From one side a search may end in an optimum of its own that from the other it never meets.
    """
    found = []
    for effect in child.hypothesis.ids[:-1]:  # without the last one is where it came from
        rest = frozenset(child.hypothesis.ids) - {effect}
        sides = [f for f in tried if frozenset(f.hypothesis.ids) == rest and f.converged]
        if sides and not child.hypothesis.rough:
            side = min(sides, key=lambda f: f.rms)
            (form,) = (f for f in child.hypothesis.forms if f.effect == effect)
            found.append(fit(predictor, side.hypothesis.with_form(form), side, screen=-np.inf))
    return found


def without_each(predictor: Predictor, full: Fit) -> list[Fit]:
    """The fit without each of its effects in turn, searched from where the whole one ended."""
    if len(full.hypothesis.forms) < 2:
        return []
    return [
        fit(predictor, full.hypothesis.without(effect), full, screen=-np.inf)
        for effect in full.hypothesis.ids
    ]
