"""What 27 RMS values can tell apart, by the singular values of their derivatives."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from ..effects import Form
from ..hypothesis import Fit, Hypothesis
from ..machine import Array
from .fitting import TableFitter

ALIKE = 0.95  # cosine between effects from which on the table cannot separate them
VISIBLE = 0.5  # share of its typical size to which a parameter must be known to be visible


@dataclass(frozen=True, kw_only=True)
class Identifiability:
    """Directions in the space of all candidate parameters that the table determines."""

    parameters: int
    determined: int  # directions known to better than VISIBLE of the typical size
    alike: tuple[tuple[str, str, float], ...]  # parameters whose effects on the table are alike
    invisible: tuple[str, ...]  # parameters that move no value by its scatter


def identifiability(
    fitter: TableFitter, retuned: Fit, forms: Sequence[Form], relative: float
) -> Identifiability:
    """At the starting values of each form's parameters; ``relative`` is the scatter of a value."""
    names, columns = [], []
    own = _slopes(fitter, Hypothesis(), retuned)
    for form in _one_form_each(forms):
        hypothesis = Hypothesis(forms=(form,))
        slopes = _slopes(fitter, hypothesis, retuned)
        for key, column in zip((k for k in fitter.problem(hypothesis).keys), slopes.T):
            if key[0]:
                names.append(f"{key[0]}: {key[1]}")
                columns.append(column / relative)
    table = np.column_stack(columns)
    sizes = np.linalg.norm(table, axis=0)
    seen = [i for i, size in enumerate(sizes) if size > 1.0 / VISIBLE]
    # What the retuning of own parameters can imitate says nothing of an effect.
    q, _ = np.linalg.qr(own)
    rest = table - q @ (q.T @ table)
    alike = []
    for i, j in combinations(seen, 2):
        cosine = abs(_cosine(rest[:, i], rest[:, j]))
        if cosine > ALIKE and names[i].split(":")[0] != names[j].split(":")[0]:
            alike.append((names[i], names[j], cosine))
    values = np.linalg.svd(table, compute_uv=False)
    return Identifiability(
        parameters=len(names),
        determined=int(np.sum(values > 1.0 / VISIBLE)),
        alike=tuple(sorted(alike, key=lambda pair: -pair[2])),
        invisible=tuple(name for i, name in enumerate(names) if i not in seen),
    )


def _one_form_each(forms: Sequence[Form]) -> list[Form]:
    return list({form.effect: form for form in reversed(forms)}.values())[::-1]


def _slopes(fitter: TableFitter, hypothesis: Hypothesis, retuned: Fit) -> Array:
    problem = fitter.problem(hypothesis)
    known = retuned.by_key()
    starts = [known.get(k, p.starts[0]) for k, p in zip(problem.keys, problem.parameters)]
    return problem.jacobian(problem.inside(np.array(starts) / problem.scale))


def _cosine(a: Array, b: Array) -> float:
    size = float(np.linalg.norm(a) * np.linalg.norm(b))
    return float(a @ b) / size if size > 0.0 else 0.0
