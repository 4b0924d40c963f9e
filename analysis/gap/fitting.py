"""Fit hypotheses to runs by prediction error, and judge them on runs they were not fitted to.

The residual is that of the machine's ``predict``: the model is driven by the logged command and says
what will be measured one sample later. It needs no model of the controller, keeps the whole
frequency content of the log and is white where the model is right (Ljung 1999, ch. 7).
"""

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from itertools import pairwise, product
from os import cpu_count
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares, lsq_linear, minimize

from .hypothesis import Fit, Hypothesis
from .machine import Array, Machine, RunData

DIVERGED = 1e6  # multiples of the signal's spread: a prediction this far off has diverged
STEP = 1e-4  # finite-difference step, in parameter scales
SCREEN = 0.004  # a form whose linearised loss falls by less than this share is not pursued
MOST_STEPS = 20  # of a least-squares search
FIRST_STEPS = 4  # of a search that is only taken further where it leads somewhere
ENOUGH = 1e-4  # relative fall of the loss that ends a search; decisions are 40 times coarser
ROUGH_STEPS = 60, 120  # predictions of all runs in a search without derivatives: effects, then all
MOST_ROUNDS = 2  # of both searches
ROUND = 0.02  # relative fall of the loss that is worth another round
BLOCKS = 30  # blocks of a run whose losses are resampled together
FEW_RUNS = 2  # up to this many are held out by stretches of time, not whole
FOLDS = 4  # stretches of such a run


class Predictor:
    """Predicts runs with hypotheses and counts what it costs."""

    def __init__(self, machine: Machine, runs: Sequence[RunData]) -> None:
        self.machine = machine
        self.runs = list(runs)
        self.simulations = 0
        self.spread = machine.spread(self.runs)
        self._pool = ThreadPoolExecutor(max_workers=cpu_count() or 1)

    def residuals(
        self,
        hypothesis: Hypothesis,
        points: Iterable[Array],
        keys: Sequence[tuple[str, str]],
        runs: Sequence[RunData] | None = None,
    ) -> list[list[Array]]:
        """Residuals (samples, n) of every run at every point, in parallel."""
        tasks = []
        chosen = self.runs if runs is None else runs
        for point in points:
            values = dict(zip(keys, point))
            plants = {t: hypothesis.plant(self.machine, values, t) for t in _times(chosen)}
            tasks.append(
                [self._pool.submit(self._predict, run, plants[run.start]) for run in chosen]
            )
        return [[task.result() for task in row] for row in tasks]

    def _predict(self, run: RunData, plant: Any) -> Array:
        residual = self.machine.predict(run, plant)
        self.simulations += 1
        if not np.all(np.abs(residual) < DIVERGED * self.spread):  # NaN is not, either
            residual = np.full_like(residual, DIVERGED * self.spread)
        return residual


def _times(runs: Sequence[RunData]) -> set[float]:
    return {run.start for run in runs}


class _Problem:
    """Residuals of a hypothesis as functions of its free parameters in units of their scales."""

    def __init__(self, predictor: Predictor, hypothesis: Hypothesis) -> None:
        free = hypothesis.free(predictor.machine)
        self.predictor = predictor
        self.hypothesis = hypothesis
        self.keys = tuple((effect, p.name) for effect, p in free)
        self.parameters = [p for _, p in free]
        self.scale = np.array([p.scale for p in self.parameters])
        self.lower = np.array([p.lower for p in self.parameters]) / self.scale
        self.upper = np.array([p.upper for p in self.parameters]) / self.scale
        self.step = max([STEP, *(form.step for form in hypothesis.forms)])
        self.rough = hypothesis.rough
        self.of_effects = np.array([effect != "" for effect, _ in free], dtype=bool)

    def runs(self, points: Sequence[Array], runs: Sequence[RunData] | None = None) -> list[Any]:
        """Residuals of the runs at every point."""
        scaled = [self.scale * x for x in points]
        return self.predictor.residuals(self.hypothesis, scaled, self.keys, runs)

    def flat(self, x: Array) -> Array:
        """All residuals at ``x`` in one vector."""
        return _flatten(self.runs([x])[0])

    def jacobian(self, x: Array) -> Array:
        """Derivatives of ``flat`` by differences that stay inside the bounds."""
        return self.columns(x, self.flat(x), range(x.size))

    def columns(self, x: Array, residual: Array, which: Sequence[int]) -> Array:
        """Some columns of the Jacobian at ``x``, where the residual is known."""
        steps = np.where(x + self.step > self.upper, -self.step, self.step)
        points = [x + steps[i] * unit for i, unit in zip(which, np.eye(x.size)[list(which)])]
        moved = [_flatten(r) for r in self.runs(points)]
        return np.column_stack([(m - residual) / steps[i] for m, i in zip(moved, which)])

    def linearised(self, x: Array, parent: Fit | None) -> tuple[Array, Array]:
        """Residual and Jacobian at ``x``; what the parent knows of this point is taken from it."""
        if parent is None or not self.extends(parent, x):
            residual = self.flat(x)
            return residual, self.columns(x, residual, range(x.size))
        new = [i for i, key in enumerate(self.keys) if key not in parent.keys]
        jac = np.empty((parent.residual.size, x.size))
        old = [i for i in range(x.size) if i not in new]
        jac[:, old] = parent.jacobian[:, [parent.keys.index(self.keys[i]) for i in old]]
        if new:
            jac[:, new] = self.columns(x, parent.residual, new)
        return parent.residual, jac

    def extends(self, parent: Fit, x: Array) -> bool:
        """Whether ``x`` is the parent's point with every further parameter at zero effect."""
        known = parent.by_key()
        if any(key not in self.keys for key in parent.keys) or self.step > STEP:
            return False
        neutral = {(form.effect, name) for form in self.hypothesis.forms for name in form.shapes}
        return all(
            np.isclose(value, known[key], rtol=1e-12, atol=0.0)
            if key in known
            else value == 0.0 or key in neutral
            for key, value in zip(self.keys, self.scale * x)
        )

    def inside(self, x: Array) -> Array:
        """``x`` drawn a little into the bounds, where trust-region searches start."""
        margin = 1e-3 * np.minimum(self.upper - self.lower, 1.0)
        return np.clip(x, self.lower + margin, self.upper - margin)


def fit(
    predictor: Predictor,
    hypothesis: Hypothesis,
    warm: Fit | None = None,
    screen: float = SCREEN,
    steps: int = MOST_STEPS,
) -> Fit:
    """Best parameters of a hypothesis on the predictor's runs, with held-out losses.

    ``warm`` is a fit whose values are starting points where the keys agree. A hypothesis whose
    linearised loss cannot fall below that of ``warm`` by the share ``screen`` is taken where the linear
    step leads and not searched further; its held-out losses are those of ``warm``, scaled by that gain.
    ``steps`` bounds the search; a fit that used them all is not ``finished``.
    """
    problem = _Problem(predictor, hypothesis)
    x, jac, searched, finished = _search(problem, warm, screen, steps)
    final = problem.runs([x])[0]
    span = np.minimum(problem.upper - problem.lower, 1.0)
    at_bound = (x - problem.lower < 1e-4 * span) | (problem.upper - x < 1e-4 * span)
    residual = _flatten(final)
    if searched or warm is None:
        losses, samples = block_losses(_held_out(problem, final, jac, x, at_bound))
    else:  # it is as good on held-out runs as its parent, but for the little it gained on fit runs
        losses, samples = warm.losses * np.mean(residual**2) / warm.rms**2, warm.samples
    held_out = float(np.sqrt(losses.sum() / samples.sum()))
    spread = predictor.machine.spread(predictor.runs)
    deviation, importance = _information(problem, jac, residual, x)
    if problem.rough:  # the slopes between impacts say nothing of how far a parameter may be off
        deviation = np.full(x.size, np.nan)
    return Fit(
        hypothesis=hypothesis,
        keys=problem.keys,
        units=tuple(p.unit for p in problem.parameters),
        values=problem.scale * x,
        deviation=problem.scale * deviation,
        at_bound=at_bound,
        losses=losses,
        samples=samples,
        rms=float(np.sqrt(np.mean(residual**2))),
        held_out_rms=held_out,
        importance=importance,
        converged=bool(np.mean(residual**2) < spread**2 and held_out < spread),
        residual=residual,
        jacobian=jac,
        finished=finished,
    )


def _search(
    problem: _Problem, parent: Fit | None, screen: float, steps: int
) -> tuple[Array, Array, bool, bool]:
    """Best point, its Jacobian, whether a search led there or only a linear step, and whether it ended."""
    if problem.rough:
        return _search_impacts(problem, parent, screen)
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
    problem: _Problem, parent: Fit | None, screen: float
) -> tuple[Array, Array, bool, bool]:
    """As ``_search``, for impacts: their residuals are too rough for derivatives.

    The best of all combinations of starting values is improved by simplex searches, of the effects'
    parameters and then of all. Where it lowers the parent's loss by less than the share ``screen``, no
    search is made.
    """
    x = _starts(problem, parent, together=True)[0]
    cost = float(np.sum(problem.flat(x) ** 2))
    if parent is not None and cost > (1.0 - screen) * float(np.sum(parent.residual**2)):
        return x, np.zeros((parent.residual.size, x.size)), False, True
    everything = np.ones(x.size, dtype=bool)
    for _ in range(MOST_ROUNDS):
        before = cost
        for free, most in zip((problem.of_effects, everything), ROUGH_STEPS):
            x, cost = _simplex_search(problem, x, free, most)
        if cost > (1.0 - ROUND) * before:
            break
    return x, problem.jacobian(x), True, True


def _least_squares(
    problem: _Problem, start: Array, residual: Array, steps: int
) -> tuple[Array, Array, bool]:
    """Point and Jacobian that a bounded trust-region search ends at, and whether it ended by itself.

    Residuals are normalised.
    """
    unit = float(np.sqrt(np.mean(residual**2)))

    def residuals(x: Array) -> Array:
        return problem.flat(x) / unit

    def jacobian(x: Array) -> Array:
        return problem.jacobian(x) / unit

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


def _simplex_search(
    problem: _Problem, x: Array, free: NDArray[np.bool_], most: int
) -> tuple[Array, float]:
    """Point and loss of a Nelder-Mead search from ``x`` over the ``free`` parameters."""

    def inside(part: Array) -> Array:
        point = x.copy()
        point[free] = part
        return np.clip(point, problem.lower, problem.upper)

    def loss(part: Array) -> float:
        return float(np.sum(problem.flat(inside(part)) ** 2))

    size = np.where(problem.of_effects, 0.15 * np.maximum(np.abs(x), 0.2), 2e-3)
    size = np.where(x + size > problem.upper, -size, size)[free]
    simplex = np.vstack([x[free], x[free] + np.diag(size)])
    solution = minimize(
        loss, x[free], method="Nelder-Mead", options={"maxfev": most, "initial_simplex": simplex}
    )
    return inside(solution.x), float(solution.fun)


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


def block_losses(residuals: Sequence[Array]) -> tuple[Array, Array]:
    """Squared residuals summed over blocks of every run, and the number of values in each block."""
    pieces = [piece for r in residuals for piece in np.array_split(r, min(BLOCKS, len(r)), axis=0)]
    return np.array([np.sum(p**2) for p in pieces]), np.array([float(p.size) for p in pieces])


def _flatten(residuals: Sequence[Array]) -> Array:
    return np.concatenate([r.ravel() for r in residuals])


def _starts(problem: _Problem, warm: Fit | None, together: bool = False) -> list[Array]:
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
    costs = np.array([np.sum(_flatten(r) ** 2) for r in problem.runs(candidates)])
    order = np.argsort(costs)
    return [candidates[i] for i in (order[:2] if costs[order[0]] < costs[0] else order[:1])]


def _held_out(
    problem: _Problem, final: Sequence[Array], jac: Array, x: Array, at_bound: Array
) -> list[Array]:
    """Residuals of every piece at parameters that did not see it.

    The parameters without a piece are one Gauss-Newton step from the full solution, the piece is then
    predicted in full. A piece is a run, or a stretch of time where runs are few: one of two runs may be the
    only one that shows a parameter.
    """
    if x.size == 0:
        return list(final)
    n = final[0].shape[1]
    starts = np.concatenate([[0], np.cumsum([r.size for r in final])])
    parts = 1 if len(final) > FEW_RUNS else FOLDS
    pieces = [
        (i, slice(int(a), int(b)))
        for i, r in enumerate(final)
        for a, b in pairwise(np.linspace(0, len(r), parts + 1).astype(int))
    ]
    residual = _flatten(final)
    active = np.logical_not(at_bound)
    # Directions that the data leave free stay inside the bounds by their prior, as in ``_information``.
    variance = _variance(residual, x.size)
    prior = variance * 12.0 / np.square(problem.upper - problem.lower)[active]
    ridge = np.diag(prior + 1e-9 * max(float(np.sum(jac**2)), 1e-300))
    hessian, gradient = jac[:, active].T @ jac[:, active], jac[:, active].T @ residual
    held_out = [np.array(r) for r in final]
    for run, piece in pieces:
        rows = slice(starts[run] + n * piece.start, starts[run] + n * piece.stop)
        J = jac[rows][:, active]
        step = np.zeros(x.size)
        step[active] = -np.linalg.solve(hessian - J.T @ J + ridge, gradient - J.T @ residual[rows])
        point = np.clip(x + step, problem.lower, problem.upper)
        held_out[run][piece] = problem.runs([point], [problem.predictor.runs[run]])[0][0][piece]
    return held_out


def _information(problem: _Problem, jac: Array, residual: Array, x: Array) -> tuple[Array, Array]:
    """Standard deviations and importances from the Gauss-Newton Hessian.

    Samples count as far as the residual is uncorrelated; a bounded parameter has a uniform prior.
    """
    if x.size == 0:
        return np.zeros(0), np.zeros(0)
    loss = max(float(residual @ residual), 1e-300)
    variance = _variance(residual, x.size)
    prior = 12.0 / np.square(problem.upper - problem.lower)
    hessian = jac.T @ jac
    spread = np.diag(np.linalg.pinv(hessian / variance + np.diag(prior), hermitian=True))
    conditional = np.diag(np.linalg.pinv(hessian, rcond=1e-12, hermitian=True))
    seen = conditional > 0.0
    importance = np.where(seen, x**2 / np.where(seen, conditional, 1.0) / loss, 0.0)
    return np.sqrt(np.maximum(spread, 0.0)), importance


def _variance(residual: Array, parameters: int) -> float:
    """Variance of one independent sample's worth of residual."""
    loss = max(float(residual @ residual), 1e-300)
    return loss / max(effective_samples(residual), parameters + 1.0)


def effective_samples(residual: Array) -> float:
    """Number of independent samples worth of a correlated residual (initial positive sequence)."""
    centred = residual - residual.mean()
    size = centred.size
    spectrum = np.abs(np.fft.rfft(centred, 2 * size)) ** 2
    correlation = np.fft.irfft(spectrum)[: size // 2]
    if correlation[0] <= 0.0:
        return float(size)
    correlation = correlation / correlation[0]
    negative = np.flatnonzero(correlation < 0.05)
    stop = int(negative[0]) if negative.size else correlation.size
    return float(size / (1.0 + 2.0 * np.sum(correlation[1:stop])))
