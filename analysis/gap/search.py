"""Searches for the best parameters of a hypothesis: by derivatives, and without where there are impacts."""

from collections.abc import Collection, Sequence
from itertools import product

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from .evolution import FIRST_GENERATIONS, GENERATIONS, evolve
from .hypothesis import Fit
from .machine import Array
from .prediction import Problem, flatten

ENOUGH = 1e-4  # relative fall of the loss that ends a search; decisions are 40 times coarser
FEW = 9  # best starting points from which second values are tried
LINE = 1.0, 0.5, 0.2  # parts of a linear step that are tried beside impacts
MANY_STEPS = 10  # of a search by derivatives: with fewer, one by evolution is a short one too


def search(
    problem: Problem, parent: Fit | None, screen: float, steps: int
) -> tuple[Array, Array, bool, bool]:
    """Best point, its Jacobian, whether a search led there or only a linear step, and whether it ended."""
    if problem.rough:
        return _search_impacts(problem, parent, screen, steps)
    best_x, best_jac, best_cost, searched = np.zeros(0), np.zeros((0, 0)), np.inf, False
    bounds = (problem.lower, problem.upper)
    finished = True
    for start in _starts(problem, parent):
        residual, jac = problem.linearised(start, parent)
        step = linear_step(jac, residual, start, bounds)
        predicted = float(np.sum((residual + jac @ step) ** 2))
        found = [(start, jac)]
        if parent is not None and predicted > (1.0 - screen) * parent.rms**2 * residual.size:
            found.append((start + step, jac))
        else:
            searched = True
            *solution, ended = _least_squares(problem, start + 0.5 * step, residual, steps)
            found.append((solution[0], solution[1]))
            finished = finished and ended
        for x, at_x in found:
            cost = float(np.sum(problem.flat(x) ** 2))
            if cost < best_cost:
                best_x, best_jac, best_cost = x, at_x, cost
    return best_x, best_jac, searched, finished


def _search_impacts(
    problem: Problem, parent: Fit | None, screen: float, steps: int
) -> tuple[Array, Array, bool, bool]:
    """As ``search``, for impacts: their residuals are too rough for derivatives.

    The best of all combinations of starting values is improved by evolution. Where it lowers the parent's loss by
    less than the share ``screen``, no search is made. What is new beside a parent's impacts starts from where a linear
    step leads. Few ``steps`` are few generations.
    """
    x = _starts(problem, parent, together=True)[0]
    cost = float(np.sum(problem.flat(x) ** 2))
    if parent is not None and parent.hypothesis.rough:
        x, cost = _linear_start(problem, parent, x, cost)
    if parent is not None and cost > (1.0 - screen) * float(np.sum(parent.residual**2)):
        return x, np.zeros((parent.residual.size, x.size)), False, True
    first = steps < MANY_STEPS
    x = evolve(problem, x, cost, FIRST_GENERATIONS if first else GENERATIONS)
    return x, problem.jacobian(x), True, not first


def _linear_start(problem: Problem, parent: Fit, x: Array, cost: float) -> tuple[Array, float]:
    """Point and loss after the best part of a linear step in the parameters that the parent has not."""
    new = [i for i, key in enumerate(problem.keys) if key not in parent.keys]
    if not new:
        return x, cost
    residual = problem.flat(x)
    bounds = problem.lower[new], problem.upper[new]
    step = np.zeros(x.size)
    step[new] = linear_step(problem.columns(x, residual, new), residual, x[new], bounds)
    found = [(x, cost)]
    for part in LINE:
        there = x + part * step
        found.append((there, float(np.sum(problem.flat(there) ** 2))))
    return min(found, key=lambda point: point[1])


def refit(problem: Problem, start: Array, without: slice, steps: int) -> Array:
    """Point that a short search ends at which does not see some of the residuals."""
    weight = np.ones(problem.flat(start).size)
    weight[without] = 0.0
    return _least_squares(problem, start, problem.flat(start) * weight, steps, weight)[0]


def _least_squares(
    problem: Problem, start: Array, residual: Array, steps: int, weight: Array | float = 1.0
) -> tuple[Array, Array, bool]:
    """Point and Jacobian that a bounded trust-region search ends at, and whether it ended by itself.

    Residuals are normalised and may have a ``weight`` each.
    """
    unit = float(np.sqrt(np.mean(residual**2)))

    def residuals(x: Array) -> Array:
        return problem.flat(x) * weight / unit

    def jacobian(x: Array) -> Array:
        return problem.jacobian(x) * np.reshape(weight, (-1, 1)) / unit

    solution = least_squares(
        residuals,
        problem.inside(start),
        jac=jacobian,
        bounds=(problem.lower, problem.upper),
        ftol=ENOUGH,
        xtol=ENOUGH,
        gtol=1e-10,
        max_nfev=steps,
    )
    return solution.x, np.asarray(solution.jac) * unit, solution.status > 0


def linear_step(jac: Array, residual: Array, x: Array, bounds: tuple[Array, Array]) -> Array:
    """Minimiser of the linearised residual inside the bounds, as a step from ``x``."""
    if x.size == 0:
        return np.zeros(0)
    # The normal equations of a tall matrix, as a small square root: sums of squares are all it takes.
    values, vectors = np.linalg.eigh(jac.T @ jac)
    kept = values > 1e-13 * max(float(values[-1]), 1e-300)
    root = np.sqrt(values[kept])[:, None] * vectors[:, kept].T
    right = -(vectors[:, kept].T @ (jac.T @ residual)) / np.sqrt(values[kept])
    if not np.any(kept):
        return np.zeros(x.size)
    solution = lsq_linear(root, right, bounds=(bounds[0] - x, bounds[1] - x))
    return np.clip(x + solution.x, *bounds) - x


def _starts(problem: Problem, warm: Fit | None, together: bool = False) -> list[Array]:
    """Up to two starting points: the best by cost of the first values with one alternative each.

    ``together`` combines every alternative with every other.
    """
    if not problem.parameters:
        return []
    known = warm.by_key() if warm else {}
    choices = [
        (known[key],) if key in known else p.starts
        for key, p in zip(problem.keys, problem.parameters)
    ]
    if together:
        candidates = [np.array(values) / problem.scale for values in product(*choices)]
    else:
        base = np.array([values[0] for values in choices]) / problem.scale
        candidates = [base]
        for i, values in enumerate(choices):
            for value in values[1:]:
                other = base.copy()
                other[i] = value / problem.scale[i]
                candidates.append(other)
    candidates = [np.clip(c, problem.lower, problem.upper) for c in candidates]
    if len(candidates) == 1:
        return candidates
    costs = _costs(problem, candidates)
    order = np.argsort(costs)
    if together:
        return [
            _with_seconds(problem, [candidates[i] for i in order[:FEW]], costs[order[0]], known)
        ]
    return [candidates[i] for i in (order[:2] if costs[order[0]] < costs[0] else order[:1])]


def _with_seconds(
    problem: Problem, best: Sequence[Array], least: float, known: Collection[tuple[str, str]]
) -> Array:
    """The best of some starting points, best first, and of those with a second value for a parameter."""
    points = [best[0]]
    for start in best:
        for i, (key, p) in enumerate(zip(problem.keys, problem.parameters)):
            for value in () if key in known else p.seconds:
                other = start.copy()
                other[i] = value / problem.scale[i]
                points.append(other)
    costs = [least, *_costs(problem, points[1:])]
    return points[int(np.argmin(costs))]


def _costs(problem: Problem, points: Sequence[Array]) -> Array:
    """Losses at some points."""
    return np.array([np.sum(flatten(r) ** 2) for r in problem.runs(points)])
