"""Which effects: fit every hypothesis, grow the best ones, and say how sure the choice is.

Every single effect is fitted in each of its forms, scored on held-out runs, pruned of parameters
that the data do not need, and grown by forward selection while a further effect pays. How often a
hypothesis wins when the blocks of the held-out losses are resampled is its probability.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from .effects import Form
from .fitting import FIRST_STEPS, SCREEN, fit
from .hypothesis import Fit, Hypothesis
from .prediction import Predictor
from .pruning import pruned
from .ranking import Ranked, best_by_ids, rank

MOST_EFFECTS = 3
BEAM = 2  # single effects that a second one is added to
LEAST_GAIN = 0.02  # smallest fall of the score worth another effect or another set of them
FURTHER_SCREEN = 0.08  # a further effect must lower the loss by more; its price alone asks for 0.18
NEAR_FLOOR = 1.03  # a residual this close to the floor, as a ratio, leaves nothing to explain
DONE = 1.1  # nor does one this close call for a richer form of another effect
NO_SEARCH = np.inf  # a screen that no start passes: the best of the starting values is taken
ROUGH_GAIN = 0.1  # as LEAST_GAIN beside impacts, where a better optimum looks like an effect
PROMISE = 0.25  # of the fall of a sibling's loss, asked of the start of a search for impacts
CONTENDER = 1.5  # a search goes on while its residual is within this ratio of the best one's
ROUGH_CONTENDER = 1.2  # as CONTENDER, of the dear searches for impacts
FAR = 1.5  # times the floor: a residual beyond it has the other forms of the best effect grown, too
REFINED_REACH = 0.1  # of the score above the best one's, up to which a richer form is tried

Progress = Callable[[str], None]


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
    tried = _add_each(predictor, retuned, plain, progress)
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
        children = _grown(predictor, parents, plain, fits, progress)
        if reserve and (not children or children[0].held_out_rms > FAR * floor):
            children += _grown(predictor, reserve, plain, [*fits, *children], progress)
            children.sort(key=lambda f: f.score)
        reserve = []
        if best.hypothesis.rough and len(best.hypothesis.forms) == 1:
            children += _beside_impacts(predictor, retuned, best, plain, progress)
            children += _add_each(predictor, best, [f for f in plain if not f.shifts], progress)
            children.sort(key=lambda f: f.score)
        if not children:
            break
        child = pruned(predictor, children[0])
        smaller = _without_each(predictor, child)
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
    elsewise = _in_other_forms(predictor, best, plain, progress)
    fits += elsewise
    best = min([best, *elsewise], key=lambda f: f.score)
    if best.hypothesis.rough:
        fits += _with_other_shifts(predictor, best, plain, progress)
    fits += _richer(predictor, retuned, fits, best, refined, floor, progress)
    claims = [f for f in fits if f.converged and not _holds_nothing(f)]
    return rank([f.called_by_values() for f in claims], retuned, seed)


def _beam(singles: Sequence[Fit]) -> list[Fit]:
    """The best few of some fits, best first, no two of one family: those differ too little."""
    chosen: list[Fit] = []
    for candidate in singles:
        families = {f.hypothesis.forms[0].family for f in chosen} - {""}
        if candidate.hypothesis.forms[0].family not in families and len(chosen) < BEAM:
            chosen.append(candidate)
    return chosen


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
    further = []
    for f in fits:
        reach, screen = (ROUGH_CONTENDER, -np.inf) if f.hypothesis.rough else (CONTENDER, SCREEN)
        over = f.finished or f.rms > reach * best
        further.append(f if over else fit(predictor, f.hypothesis, f, screen))
    return further


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
    # Impacts are dear: beside the best only, and not where impacts themselves are far better.
    best = min((p.rms for p in parents), default=0.0)
    beside_impacts = smooth[0] if smooth and smooth[0].rms < CONTENDER * best else None
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
                and (f.step == 0.0 or parent is beside_impacts)
            ],
            progress,
        )
    ]
    return sorted(best_by_ids(children), key=lambda f: f.score)


def _beside_impacts(
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


def _with_other_shifts(
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


def _in_other_forms(
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
            if not same or other.name == mine.name or other.effect in _others(hypothesis, mine):
                continue
            progress(f"{other.effect}, {other.name} in place of {mine.effect}, {mine.name}")
            swapped = hypothesis.without(mine.effect).with_form(other)
            names = {(mine.effect, p.name): (other.effect, p.name) for p in other.parameters}
            start = replace(best, keys=tuple(names.get(key, key) for key in best.keys))
            found.append(pruned(predictor, fit(predictor, swapped, start, screen=-np.inf)))
    return found


def _others(hypothesis: Hypothesis, form: Form) -> set[str]:
    """Effects of the hypothesis but that of one form."""
    return set(hypothesis.ids) - {form.effect}


def _without_each(predictor: Predictor, full: Fit) -> list[Fit]:
    """The fit without each of its effects in turn, searched from where the whole one ended."""
    if len(full.hypothesis.forms) < 2:
        return []
    return [
        fit(predictor, full.hypothesis.without(effect), full, screen=-np.inf)
        for effect in full.hypothesis.ids
    ]


def _richer(
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


def _holds_nothing(found: Fit) -> bool:
    """Whether one of its effects has no size beyond its own uncertainty, only a shape.

    Beside impacts the uncertainty is unknown.
    """
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
