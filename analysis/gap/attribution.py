"""Which effects: fit every hypothesis, grow the best ones, and say how sure the choice is.

Every single effect is fitted in each of its forms, scored on held-out runs, pruned of parameters
that the data do not need, and grown by forward selection while a further effect pays. How often a
hypothesis wins when the blocks of the held-out losses are resampled is its probability.
"""

from collections.abc import Sequence

from .effects import Form
from .exchange import in_other_forms, richer, with_twins
from .growth import Progress
from .hypothesis import Fit
from .impacts import with_other_shifts
from .prediction import Predictor
from .ranking import Ranked, rank
from .scan import effects_looked_for
from .selection import Selection


def attribute(
    predictor: Predictor,
    retuned: Fit,
    forms: Sequence[Form],
    floor: float,
    seed: int,
    progress: Progress,
) -> list[Ranked]:
    """Every hypothesis that was tried, best first; ``floor`` in the unit of the residual."""
    looked_for = effects_looked_for(predictor)  # whose lists of shapes a spectrum replaces
    plain = [form for form in forms if not form.refined and form.effect not in looked_for]
    refined = [form for form in forms if form.refined]
    selection = Selection(predictor, retuned, plain, floor, progress)
    best, fits = selection.run(), selection.fits
    exchanged = in_other_forms(predictor, best, plain, progress)
    fits += exchanged
    best = min([best, *exchanged], key=lambda f: f.score)
    if best.hypothesis.rough:
        fits += with_other_shifts(predictor, best, plain, progress)
    fits += richer(predictor, retuned, fits, best, refined, floor, progress)
    best = min((f for f in fits if f.converged), key=lambda f: f.score, default=retuned)
    fits += with_twins(predictor, best, selection.singles, progress)
    # Everything is measured against the retuned model, however badly it predicts.
    claims = [f for f in fits if f is retuned or (f.converged and not _holds_nothing(f))]
    return rank([f.called_by_values() for f in claims], retuned, seed)


def _holds_nothing(found: Fit) -> bool:
    """Whether one of its effects has no size beyond its own uncertainty or its least, only a shape.

    Beside impacts the uncertainty is unknown.
    """
    known = found.by_key()
    if any(
        known.get((form.effect, name), least) <= least
        for form in found.hypothesis.forms
        for name, least in form.least.items()
    ):
        return True
    if found.hypothesis.rough:
        return False
    sizes = {
        key: abs(value) > 2.0 * sd
        for key, value, sd in zip(found.keys, found.values, found.deviation)
    }
    return any(
        sized and not any(sized)
        for form in found.hypothesis.forms
        for sized in [
            [
                sizes[form.effect, p.name]
                for p in found.hypothesis.kept(form)
                if p.starts[0] == 0.0 and p.name not in form.shapes
            ]
        ]
    )
