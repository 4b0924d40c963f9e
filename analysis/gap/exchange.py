"""The effects of a hypothesis in other forms: exchanged, or richer ones."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .effects import Form
from .fitting import fit
from .growth import Progress
from .hypothesis import Fit, Hypothesis
from .prediction import Predictor
from .pruning import pruned
from .selection import twins

DONE = 1.1  # a residual this close to the floor, as a ratio, calls for no richer form of another effect
REFINED_REACH = 0.1  # of the score above the best one's, up to which a richer form is tried


def in_other_forms(
    predictor: Predictor, best: Fit, forms: Sequence[Form], progress: Progress
) -> list[Fit]:
    """The best of several effects with one of them in another form, or as a plainer effect that it contains.

    Its forms were chosen one by one, each before the next effect was there.
    """
    hypothesis = best.hypothesis
    if len(hypothesis.forms) < 2 or hypothesis.rough:
        return []
    found = []
    for mine in hypothesis.forms:
        for other in forms:
            same = other.effect == mine.effect or other.effect in mine.contains
            if (
                not same
                or other.name == mine.name
                or other.effect in _others(hypothesis, mine.effect)
            ):
                continue
            progress(f"{other.effect}, {other.name} in place of {mine.effect}, {mine.name}")
            swapped = hypothesis.without(mine.effect).with_form(other)
            names = {(mine.effect, p.name): (other.effect, p.name) for p in other.parameters}
            start = replace(best, keys=tuple(names.get(key, key) for key in best.keys))
            found.append(pruned(predictor, fit(predictor, swapped, start, screen=-np.inf)))
    return found


def with_twins(
    predictor: Predictor, best: Fit, singles: Sequence[Fit], progress: Progress
) -> list[Fit]:
    """The best of several effects with one of them replaced by another that alone left the same.

    Selection goes on from one of two such effects only: from which is chance.
    """
    hypothesis = best.hypothesis
    if len(hypothesis.forms) < 2 or hypothesis.rough:
        return []
    alone = {f.hypothesis.forms[0].effect: f for f in singles if f.converged}
    found = []
    for effect in hypothesis.ids:
        mine = alone.get(effect)
        group = [f for f in alone.values() if mine is not None and (f is mine or twins(mine, f))]
        for single in group if len(group) > 1 else []:
            (form,) = single.hypothesis.forms
            # The effect itself, too, in the form whose twin the other is.
            if form in hypothesis.forms or form.effect in _others(hypothesis, effect):
                continue
            progress(f"{form.effect}, {form.name} in place of {effect}")
            start = replace(
                best,
                keys=(*single.keys, *best.keys),  # where both have a value the later one counts
                values=np.concatenate([single.values, best.values]),
            )
            swapped = hypothesis.without(effect).with_form(form)
            found.append(pruned(predictor, fit(predictor, swapped, start, screen=-np.inf)))
    return found


def _others(hypothesis: Hypothesis, effect: str) -> set[str]:
    """Effects of the hypothesis but one."""
    return set(hypothesis.ids) - {effect}


def richer(
    predictor: Predictor,
    retuned: Fit,
    fits: Sequence[Fit],
    best: Fit,
    refined: Sequence[Form],
    floor: float,
    progress: Progress,
) -> list[Fit]:
    """Hypotheses with a richer form of one of their effects, where one may be needed."""
    found: list[Fit] = []
    for form in refined:
        base = _to_refine([*fits, *found], best, form)
        if base is None and best.held_out_rms < DONE * floor:
            continue
        progress(f"{form.effect}, {form.name}")
        found.append(pruned(predictor, _refine(predictor, base, retuned, form)))
    return found


def _to_refine(fits: Sequence[Fit], best: Fit, form: Form) -> Fit | None:
    """The best hypothesis with this form's effect, if it is the best one or little worse."""
    ours = [f for f in fits if f.converged and form.effect in f.hypothesis.ids]
    base = min(ours, key=lambda f: f.score, default=None)
    return base if base is not None and base.score < best.score + REFINED_REACH else None


def _refine(predictor: Predictor, base: Fit | None, retuned: Fit, form: Form) -> Fit:
    """A hypothesis with its form of this effect made richer, or the richer form alone."""
    if base is None:
        return fit(predictor, Hypothesis(forms=(form,)), retuned)
    others = base.hypothesis
    for effect in (form.effect, *form.stands_for):
        others = others.without(effect)
    return fit(predictor, others.with_form(form), base)
