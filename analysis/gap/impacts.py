"""Effects that shift the command in time beside a clearance, whose impacts they move."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .effects import Form
from .fitting import fit
from .growth import PROMISE, Progress
from .hypothesis import Fit, Hypothesis
from .prediction import Predictor
from .ranking import best_by_ids

NO_SEARCH = np.inf  # a screen that no start passes: the best of the starting values is taken


def beside_impacts(
    predictor: Predictor, retuned: Fit, best: Fit, forms: Sequence[Form], progress: Progress
) -> list[Fit]:
    """Effects that shift the command in time, each with every form of the impacts, searched anew.

    They move the impacts, so that the best clearance without them is far from the one with them.
    """
    (impact,) = best.hypothesis.ids
    least = PROMISE * (1.0 - (best.rms / retuned.rms) ** 2)
    starts: list[Fit] = []
    # One form of each: the others are tried in its place once the best is known.
    first_forms = {form.effect: form for form in reversed(forms) if form.shifts}.values()
    for rough in (form for form in forms if form.effect == impact):
        progress(f"a command that comes late + {rough.effect}, {rough.name}")
        pairs = [Hypothesis(forms=(late, rough)) for late in first_forms]
        tried = [fit(predictor, pair, retuned, NO_SEARCH) for pair in pairs]
        starts.append(min(tried, key=lambda f: f.rms))
    return best_by_ids(
        [
            fit(predictor, start.hypothesis, start, screen=-np.inf)
            for start in starts
            if start.rms**2 < (1.0 - least) * retuned.rms**2 and _is_late(start)
        ]
    )


def _is_late(found: Fit) -> bool:
    """Whether its command comes late, not at once."""
    late = {form.effect for form in found.hypothesis.forms if form.shifts}
    return any(value > 0.0 for (effect, _), value in found.by_key().items() if effect in late)


def with_other_shifts(
    predictor: Predictor, best: Fit, forms: Sequence[Form], progress: Progress
) -> list[Fit]:
    """The fit with its shift in time made one of another kind, searched from the same mean shift.

    Where impacts are, which of the kinds was found first is chance.
    """
    swapped = []
    for mine in (form for form in best.hypothesis.forms if form.shifts):
        for other in (form for form in forms if form.shifts and form.name != mine.name):
            progress(f"{other.effect}, {other.name} in place of {mine.effect}, {mine.name}")
            key = {
                (mine.effect, p.name): (other.effect, q.name)
                for p, q in zip(mine.parameters, other.parameters)
            }
            start = replace(best, keys=tuple(key.get(k, k) for k in best.keys))
            hypothesis = best.hypothesis.without(mine.effect).with_form(other)
            swapped.append(fit(predictor, hypothesis, start, screen=-np.inf))
    return swapped
