"""Forward selection on the printed table: every effect alone, then the best two with a second one.

Smaller than ``gap.attribution.attribute``: 27 numbers carry no third effect and no richer forms.
"""

from collections.abc import Callable, Sequence

from ..effects import Form
from ..hypothesis import Fit
from ..ranking import Ranked, rank
from ..selection import LEAST_GAIN
from .fitting import TableFitter

PARENTS = 1  # single effects that a second one is added to

Progress = Callable[[str], None]


def select(
    fitter: TableFitter, retuned: Fit, forms: Sequence[Form], seed: int, progress: Progress
) -> list[Ranked]:
    """Every hypothesis that was tried, best first, by the error on tests left out."""
    singles = _add_each(fitter, retuned, forms, progress)
    fits = [retuned, *singles]
    better = [f for f in singles if retuned.score - f.score > LEAST_GAIN]
    for parent in sorted(better, key=lambda f: f.score)[:PARENTS]:
        children = _add_each(fitter, parent, forms, progress)
        fits += [c for c in children if c.score < parent.score]
    return rank(fits, retuned, seed)


def _add_each(
    fitter: TableFitter, parent: Fit, forms: Sequence[Form], progress: Progress
) -> list[Fit]:
    """The best form of each further effect added to the parent, pruned."""
    families = {form.family for form in parent.hypothesis.forms if form.family}
    best: dict[str, Fit] = {}
    for form in forms:
        if form.effect in parent.hypothesis.ids or form.family in families:
            continue
        progress(f"{parent.hypothesis.label} + {form.effect}, {form.name}")
        fitted = fitter.fit(parent.hypothesis.with_form(form), parent)
        if fitted.converged and (form.effect not in best or fitted.score < best[form.effect].score):
            best[form.effect] = fitted
    return [_pruned(fitter, f) for f in best.values()]


def _pruned(fitter: TableFitter, full: Fit) -> Fit:
    """Drop the least important removable parameter while that lowers the score."""
    current = full
    while True:
        removable = {(f.effect, name) for f in current.hypothesis.forms for name in f.removable}
        candidates = sorted(
            (float(importance), key)
            for importance, key in zip(current.importance, current.keys)
            if key in removable and sum(k[0] == key[0] and k in removable for k in current.keys) > 1
        )
        if not candidates:
            return current
        trial = fitter.fit(current.hypothesis.drop(candidates[0][1]), current)
        if trial.score > current.score:
            return current
        current = trial
