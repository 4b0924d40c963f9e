"""Which effects: fit every hypothesis, grow the best ones, and say how sure the choice is.

Every single effect is fitted in each of its forms, scored on held-out runs, pruned of parameters
that the data do not need, and grown by forward selection while a further effect pays. How often a
hypothesis wins when the blocks of the held-out losses are resampled is its probability.
"""

from collections.abc import Sequence

import numpy as np

from .effects import Form
from .exchange import in_other_forms, richer
from .growth import CONTENDER, Progress, from_other_sides, grown, with_each, without_each
from .hypothesis import Fit
from .impacts import beside_impacts, with_other_shifts
from .prediction import Predictor
from .pruning import pruned
from .ranking import Ranked, best_by_ids, rank
from .scan import effects_looked_for, forms_found

BEAM = 2  # single effects that a second one is added to
LEAST_GAIN = 0.02  # smallest fall of the score worth another effect or another set of them
ROUGH_GAIN = 0.1  # as LEAST_GAIN beside impacts, where a better optimum looks like an effect
NEAR_FLOOR = 1.03  # a residual this close to the floor, as a ratio, leaves nothing to explain
TWINS = 0.01  # of their loss, by which the residuals of twins differ at most
FAR = 1.5  # times the floor: a residual beyond it has further parents grown


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
    best, fits = _forward(predictor, retuned, plain, floor, progress)
    exchanged = in_other_forms(predictor, best, plain, progress)
    fits += exchanged
    best = min([best, *exchanged], key=lambda f: f.score)
    if best.hypothesis.rough:
        fits += with_other_shifts(predictor, best, plain, progress)
    fits += richer(predictor, retuned, fits, best, refined, floor, progress)
    claims = [f for f in fits if f.converged and not _holds_nothing(f)]
    return rank([f.called_by_values() for f in claims], retuned, seed)


def _forward(
    predictor: Predictor, retuned: Fit, forms: Sequence[Form], floor: float, progress: Progress
) -> tuple[Fit, list[Fit]]:
    """The best of forward selection, and all fits that it made."""
    forms = [*forms, *forms_found(predictor, retuned)]
    tried = with_each(predictor, retuned, forms, progress)
    singles = [pruned(predictor, f) for f in best_by_ids(tried)]
    fits = [retuned, *singles]
    parents = _beam([f for f in sorted(singles, key=lambda f: f.score) if _better(f, retuned)])
    best = parents[0] if parents else retuned
    reserve: list[Fit] = []
    if best.held_out_rms > FAR * floor:
        parents += [f for f in _other_forms(tried, parents) if _better(f, retuned)]
        reserve = [f for f in _beam(sorted(singles, key=lambda f: f.rms)) if f not in parents]
    while parents:
        # Impacts do not repeat: they raise the floor that they are measured by.
        if best.held_out_rms < NEAR_FLOOR * floor and not best.hypothesis.rough:
            break
        children = grown(predictor, parents, forms, fits, progress)
        if reserve and (not children or children[0].held_out_rms > FAR * floor):
            children += grown(predictor, reserve, forms, [*fits, *children], progress)
        reserve = []
        if best.hypothesis.rough and len(best.hypothesis.forms) == 1:
            children += beside_impacts(predictor, retuned, best, forms, progress)
            children += with_each(predictor, best, [f for f in forms if not f.shifts], progress)
        if not children:
            break
        children.sort(key=lambda f: f.score)
        child = pruned(predictor, children[0])
        if child.held_out_rms > FAR * floor:
            sides = from_other_sides(predictor, child, [*tried, *fits])
            child = min([child, *(pruned(predictor, f) for f in sides)], key=lambda f: f.score)
        smaller = without_each(predictor, child)
        fits += [child, *children[1:], *smaller]
        found = min([child, *smaller], key=lambda f: f.score)
        if best.score - found.score < (ROUGH_GAIN if best.hypothesis.rough else LEAST_GAIN):
            break
        before = {frozenset(p.hypothesis.ids) for p in parents}
        best = found
        # What the new effect made needless, or look different, may have another partner.
        parents = [best] + [
            f for f in smaller if f is not best and frozenset(f.hypothesis.ids) not in before
        ]
    return best, fits


def _beam(singles: Sequence[Fit]) -> list[Fit]:
    """The best few of some fits, best first, no two of one family or of one residual: those differ too little."""
    chosen: list[Fit] = []
    for candidate in singles:
        families = {f.hypothesis.forms[0].family for f in chosen} - {""}
        known = candidate.hypothesis.forms[0].family in families
        if not known and len(chosen) < BEAM and not any(_twins(candidate, f) for f in chosen):
            chosen.append(candidate)
    return chosen


def _twins(a: Fit, b: Fit) -> bool:
    """Whether two fits leave the same, as a gain of the actuator and a scale of the encoder do."""
    apart = float(np.sum((a.residual - b.residual) ** 2))
    return apart < TWINS * float(np.sum(a.residual**2))


def _other_forms(tried: Sequence[Fit], parents: Sequence[Fit]) -> list[Fit]:
    """Fits of the best parent's effect in its other forms, where they are not far behind.

    Alone, the form that imitates a missing effect best wins; beside that effect another one may.
    """
    best = parents[0] if parents else None
    return [
        f
        for f in tried
        if best is not None
        and f.hypothesis.ids == best.hypothesis.ids
        and f.hypothesis.forms[0].name != best.hypothesis.forms[0].name
        and f.rms < CONTENDER * best.rms
    ]


def _better(candidate: Fit, retuned: Fit) -> bool:
    return candidate.converged and retuned.score - candidate.score > LEAST_GAIN


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
