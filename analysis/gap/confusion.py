"""Which effects these runs cannot separate, and which could not have shown up, whatever was found.

Every effect is given a typical size on the retuned machine. What it then changes in the prediction,
less what the machine's own parameters can take up inside their tolerance, is its fingerprint on these
trajectories. An effect whose fingerprint is lost in the floor could not have shown up. One that another
effect reproduces with its own parameters, to first order, is confused with that one.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.optimize import lsq_linear

from .effects import Form
from .hypothesis import Fit, Hypothesis
from .machine import Array, Parameter
from .prediction import Predictor
from .selection import LEAST_GAIN

TYPICAL = 0.5  # of a parameter's scale, where a form names no other size to start from
MOST = 10.0  # prediction error, in rms of what is predicted, above which a typical size runs away
STEP = 0.3  # relative change of a parameter that shows what else its form can look like
# Multiples of the floor that change the log residual by ``LEAST_GAIN``: less is not told apart.
TOLD_APART = float(np.sqrt(np.exp(2.0 * LEAST_GAIN) - 1.0))


@dataclass(frozen=True, kw_only=True)
class Confusion:
    """Fingerprints of the effects on a set of runs, rms in multiples of the floor."""

    effects: tuple[str, ...]
    size: Array  # (k,) of each effect at its typical size
    left: Array  # (k, k) of the row's effect, after the column's effect has reproduced it

    @property
    def invisible(self) -> list[str]:
        """Effects that could not have shown up at their typical size."""
        return [e for e, size in zip(self.effects, self.size) if size < TOLD_APART]

    @property
    def pairs(self) -> list[tuple[str, str]]:
        """Visible effects, each with a visible one that passes for it."""
        seen = self.size >= TOLD_APART
        found = np.argwhere((self.left < TOLD_APART) & np.outer(seen, seen))
        return [(self.effects[i], self.effects[j]) for i, j in found if i != j]

    def to_json(self) -> dict[str, Any]:
        """Effects, fingerprints, the matrix and what follows from them."""
        return {
            "unit": "multiples of the noise floor",
            "effects": list(self.effects),
            "fingerprint": [float(s) for s in self.size],
            "left": [[float(v) for v in row] for row in self.left],
            "told_apart_above": TOLD_APART,
            "pairs": [list(pair) for pair in self.pairs],
            "invisible": self.invisible,
        }


def confusion(predictor: Predictor, retuned: Fit, forms: Sequence[Form], floor: float) -> Confusion:
    """Fingerprints by the first form of every effect; ``floor`` in the unit of the residual."""
    first: dict[str, Form] = {}
    for form in forms:
        if not form.refined:
            first.setdefault(form.effect, form)
    changes = {e: _changes(predictor, retuned, form) for e, form in first.items()}
    known = {e: change for e, change in changes.items() if change is not None}
    scale = floor * np.sqrt(retuned.residual.size)
    columns = np.column_stack([retuned.jacobian, *known.values()]) / scale
    root: Array = np.linalg.qr(columns).R  # all that lengths and projections need
    starts = retuned.values.size + np.cumsum([0, *(c.shape[1] for c in known.values())])
    spans = [np.arange(a, b) for a, b in pairwise(starts)]
    own = {p.name: p for p in predictor.machine.own}
    free = [(own[name], value) for (_, name), value in zip(retuned.keys, retuned.values)]
    bounds = (
        np.array([(p.lower - value) / p.scale for p, value in free]),
        np.array([(p.upper - value) / p.scale for p, value in free]),
    )
    size, left = np.zeros(len(known)), np.zeros((len(known), len(known)))
    for i, span in enumerate(spans):
        target = root[:, span[0]]
        size[i] = _remainder(root, target, np.zeros(0), bounds)
        for j, other in enumerate(spans):
            left[i, j] = 0.0 if i == j else _remainder(root, target, other, bounds)
    return Confusion(effects=tuple(known), size=size, left=left)


def _remainder(root: Array, target: Array, other: Array, bounds: tuple[Array, Array]) -> float:
    """Length of ``target`` that own parameters inside their bounds and ``other`` columns leave.

    ``root`` starts with the columns of the own parameters.
    """
    basis, values, _ = np.linalg.svd(root[:, other.astype(int)], full_matrices=False)
    basis = basis[:, values > 1e-9 * np.max(values, initial=0.0)]
    own = root[:, : len(bounds[0])]

    def beyond(columns: Array) -> Array:
        return columns - basis @ (basis.T @ columns)

    free = bounds[1] > bounds[0]
    found = lsq_linear(
        beyond(own[:, free]),
        beyond(target),
        bounds=(bounds[0][free], bounds[1][free]),
        method="bvls",
    )
    return float(np.linalg.norm(found.fun))


def _changes(predictor: Predictor, retuned: Fit, form: Form) -> Array | None:
    """What the form at its typical size changes (residuals, 1 + p), and how each parameter alters that.

    None where a prediction diverges.
    """
    hypothesis = Hypothesis(forms=(form,))
    typical = {(form.effect, p.name): _typical(p) for p in form.parameters}
    points = [typical]
    for p in form.parameters:
        key = (form.effect, p.name)
        points.append(typical | {key: min(max((1.0 + STEP) * typical[key], p.lower), p.upper)})
    known = retuned.by_key()
    keys = tuple(known) + tuple(typical)
    values = [np.array([*known.values(), *point.values()]) for point in points]
    found = [
        np.concatenate([r.ravel() for r in run])
        for run in predictor.residuals(hypothesis, values, keys)
    ]
    if any(np.max(np.abs(r)) > MOST * predictor.spread for r in found):
        return None
    main = found[0] - retuned.residual
    return np.column_stack([main, *(r - found[0] for r in found[1:])])


def _typical(p: Parameter) -> float:
    start = next((s for s in p.starts if s != 0.0), TYPICAL * p.scale)
    return float(min(max(start, p.lower), p.upper))
