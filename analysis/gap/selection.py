"""Forward selection: the best single effects, each joined by a further one while that pays."""

from collections.abc import Sequence

import numpy as np

from .effects import Form
from .growth import CONTENDER, Progress, from_other_sides, grown, with_each, without_each
from .hypothesis import Fit
from .impacts import beside_impacts
from .prediction import Predictor
from .pruning import pruned
from .ranking import best_by_ids
from .scan import Spectra

BEAM = 2  # single effects that a second one is added to
LEAST_GAIN = 0.02  # smallest fall of the score worth another effect or another set of them
ROUGH_GAIN = 0.1  # as LEAST_GAIN beside impacts, where a better optimum looks like an effect
NEAR_FLOOR = 1.03  # a residual this close to the floor, as a ratio, leaves nothing to explain
TWINS = 0.01  # of their loss, by which the residuals of twins differ at most
FAR = 1.5  # times the floor: a residual beyond it has further parents grown


class Selection:
    """One forward selection; ``fits`` are all that it made, ``tried`` all single effects in all their forms."""

    def __init__(
        self,
        predictor: Predictor,
        retuned: Fit,
        forms: Sequence[Form],
        floor: float,
        progress: Progress,
    ) -> None:
        self.predictor, self.retuned, self.floor, self.progress = (
            predictor,
            retuned,
            floor,
            progress,
        )
        self.spectra = Spectra(predictor, retuned)
        self.forms = [*forms, *self.spectra.forms_beside(retuned)]
        self.tried = with_each(predictor, retuned, self.forms, progress)
        self.singles = [pruned(predictor, f) for f in best_by_ids(self.tried)]
        self.fits = [retuned, *self.singles]

    def run(self) -> Fit:
        """The best fit."""
        parents, reserve = self._first_parents()
        best = parents[0] if parents else self.retuned
        # Impacts do not repeat: they raise the floor that they are measured by.
        while parents and (best.held_out_rms > NEAR_FLOOR * self.floor or best.hypothesis.rough):
            children = self._children(parents, reserve)
            reserve = []
            if not children:
                break
            child = self._settled(children[0])
            smaller = without_each(self.predictor, child)
            self.fits += [child, *children[1:], *smaller]
            found = min([child, *smaller], key=lambda f: f.score)
            if best.score - found.score < (ROUGH_GAIN if best.hypothesis.rough else LEAST_GAIN):
                break
            best, before = found, {frozenset(p.hypothesis.ids) for p in parents}
            # What the new effect made needless, or look different, may have another partner.
            parents = [best] + [
                f for f in smaller if f is not best and frozenset(f.hypothesis.ids) not in before
            ]
        return best

    def _first_parents(self) -> tuple[list[Fit], list[Fit]]:
        """Single effects that a second one is added to, best first, and those to turn to where that leads nowhere."""
        by_score = sorted(self.singles, key=lambda f: f.score)
        parents = _beam([f for f in by_score if self._better(f)])
        if not parents or parents[0].held_out_rms <= FAR * self.floor:
            return parents, []
        parents += [f for f in _other_forms(self.tried, parents) if self._better(f)]
        by_rms = sorted(self.singles, key=lambda f: f.rms)
        return parents, [f for f in _beam(by_rms) if f not in parents]

    def _children(self, parents: Sequence[Fit], reserve: Sequence[Fit]) -> list[Fit]:
        """The parents with one effect more, best first."""
        children = self._grown(parents, self.forms, self.fits)
        if reserve and (not children or children[0].held_out_rms > FAR * self.floor):
            # Where impacts are the best, every other effect joins them below.
            forms = [f for f in self.forms if f.step == 0.0 or not parents[0].hypothesis.rough]
            children += self._grown(reserve, forms, [*self.fits, *children])
        best = parents[0]
        if best.hypothesis.rough and len(best.hypothesis.forms) == 1:
            children += beside_impacts(
                self.predictor, self.retuned, best, self.forms, self.progress
            )
            on_time = [f for f in self.forms if not f.shifts]
            children += with_each(self.predictor, best, on_time, self.progress)
        return sorted(children, key=lambda f: f.score)

    def _grown(
        self, parents: Sequence[Fit], forms: Sequence[Form], known: Sequence[Fit]
    ) -> list[Fit]:
        """``parents`` with one of ``forms`` each, best first, where the set of effects is not known."""
        return grown(self.predictor, parents, forms, self.spectra, known, self.progress)

    def _settled(self, child: Fit) -> Fit:
        """A child without needless parameters, searched from its other sides too where it is far from the floor."""
        child = pruned(self.predictor, child)
        if child.held_out_rms <= FAR * self.floor:
            return child
        sides = from_other_sides(self.predictor, child, [*self.tried, *self.fits])
        return min([child, *(pruned(self.predictor, f) for f in sides)], key=lambda f: f.score)

    def _better(self, candidate: Fit) -> bool:
        return candidate.converged and self.retuned.score - candidate.score > LEAST_GAIN


def _beam(singles: Sequence[Fit]) -> list[Fit]:
    """The best few of some fits, best first, no two of one family or of one residual: those differ too little."""
    chosen: list[Fit] = []
    for candidate in singles:
        families = {f.hypothesis.forms[0].family for f in chosen} - {""}
        known = candidate.hypothesis.forms[0].family in families
        if not known and len(chosen) < BEAM and not any(twins(candidate, f) for f in chosen):
            chosen.append(candidate)
    return chosen


def twins(a: Fit, b: Fit) -> bool:
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
