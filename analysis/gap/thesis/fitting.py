"""Fit hypotheses to the printed table and judge them on motions and controllers left out of it."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares, lsq_linear

from ..drive_machine import DriveMachine
from ..hypothesis import Fit, Hypothesis
from ..machine import Array
from ..scaled import ScaledParameters
from .experiment import METRICS, TESTS, Experiment, Scatter
from .loops import BenchmarkLoops

STEP = 1e-3  # finite-difference step, in parameter scales
MOST_STEPS = 12  # of a search
SCREEN = 0.02  # a form whose linearised loss falls by less than this share is not pursued
DIVERGED = 3.0  # largest relative error; where a loop diverges, how fast says nothing
DAMPING = 1e-4  # of steps to a solution with other weights, relative to the largest curvature
FOLDS = tuple(
    tuple(i for i, test in enumerate(TESTS) if test[place] == name)
    for place in (0, 1)
    for name in dict.fromkeys(test[place] for test in TESTS)
)  # each controller, then each motion; every test is left out twice


class TableProblem(ScaledParameters):
    """Relative errors of a hypothesis against one table, as functions of its free parameters."""

    def __init__(
        self,
        machine: DriveMachine,
        loops: BenchmarkLoops,
        experiment: Experiment,
        scatter: Scatter,
        hypothesis: Hypothesis,
    ) -> None:
        super().__init__(hypothesis, machine)
        self._machine, self._loops = machine, loops
        self._experiment, self._scatter = experiment, scatter
        self._step = max([STEP, *(form.step for form in hypothesis.forms)])

    def metrics(self, points: Sequence[Array]) -> Array:
        """Metrics (points, 9, 3) at points in parameter scales."""
        plants = [
            self.hypothesis.plant(self._machine, dict(zip(self.keys, self.scale * x)))
            for x in points
        ]
        return self._loops.metrics(plants)

    def all_errors(self, points: Sequence[Array]) -> Array:
        """Relative errors (points, 9, 3)."""
        measured = self._experiment.measured
        errors = [self._scatter.relative_error(m, measured) for m in self.metrics(points)]
        return np.minimum(np.array(errors), DIVERGED)

    def errors(self, x: Array) -> Array:
        """Relative errors (9, 3) at ``x``."""
        return np.asarray(self.all_errors([x])[0])

    def _flat_errors(self, x: Array) -> Array:
        return self.errors(x).ravel()

    def jacobian(self, x: Array) -> Array:
        """Derivatives (27, p) of the errors by differences that stay inside the bounds."""
        steps = self.steps(x, self._step)
        points = [x, *(x + step * unit for step, unit in zip(steps, np.eye(x.size)))]
        errors = self.all_errors(points).reshape(len(points), -1)
        return np.asarray(((errors[1:] - errors[0]) / steps[:, None]).T)

    def search(self, start: Array) -> Array:
        """Best point that a bounded trust-region search from ``start`` finds."""
        if not self.parameters:
            return start
        solution = least_squares(
            self._flat_errors,
            self.inside(start),
            jac=self.jacobian,
            bounds=(self.lower, self.upper),
            ftol=1e-3,
            xtol=1e-3,
            max_nfev=MOST_STEPS,
        )
        return np.asarray(solution.x)

    def moved(self, x: Array, errors: Array, jacobian: Array, weights: Array) -> Array:
        """Where the linearised problem has its bounded minimum if tests count by ``weights`` (9,)."""
        if not self.parameters:
            return x
        root = np.repeat(np.sqrt(weights), len(METRICS))
        damping = np.sqrt(DAMPING * np.max(np.sum(jacobian**2, axis=0))) * np.eye(x.size)
        rows = np.vstack([root[:, None] * jacobian, damping])
        target = np.concatenate([-root * errors.ravel(), np.zeros(x.size)])
        slack = 1e-12
        step = lsq_linear(rows, target, bounds=(self.lower - x - slack, self.upper - x + slack))
        return np.clip(x + step.x, self.lower, self.upper)


class TableFitter:
    """Fits hypotheses to one table."""

    def __init__(
        self, machine: DriveMachine, loops: BenchmarkLoops, experiment: Experiment, scatter: Scatter
    ) -> None:
        self.machine = machine
        self.loops = loops
        self.experiment = experiment
        self.scatter = scatter

    def problem(self, hypothesis: Hypothesis) -> TableProblem:
        """The hypothesis against this table."""
        return TableProblem(self.machine, self.loops, self.experiment, self.scatter, hypothesis)

    def fit(self, hypothesis: Hypothesis, warm: Fit | None = None) -> Fit:
        """Best parameters on the whole table, with losses on the tests left out in turn.

        ``warm`` is a fit whose values are starting points where the keys agree. What cannot beat it
        even if it were linear is not pursued.
        """
        problem = self.problem(hypothesis)
        x = self._search(problem, warm)
        errors, jacobian = problem.errors(x), problem.jacobian(x)
        losses = self._held_out(problem, x, errors, jacobian)
        deviation, importance = _information(jacobian, errors, x)
        margin = 1e-3 * np.minimum(problem.upper - problem.lower, 1.0)
        rms = float(np.sqrt(np.mean(errors**2)))
        return Fit(
            hypothesis=hypothesis,
            keys=problem.keys,
            units=tuple(p.unit for p in problem.parameters),
            values=problem.scale * x,
            deviation=problem.scale * deviation,
            at_bound=(x - problem.lower < margin) | (problem.upper - x < margin),
            losses=losses,
            samples=np.full(len(TESTS), float(len(METRICS))),
            rms=rms,
            held_out_rms=float(np.sqrt(losses.mean() / len(METRICS))),
            importance=importance,
            converged=bool(rms < 1.0),
            residual=errors.ravel(),
            jacobian=jacobian,
        )

    def errors(self, fitted: Fit) -> Array:
        """Relative errors (9, 3) of a fit on this table, whatever table it was fitted to."""
        problem = self.problem(fitted.hypothesis)
        return problem.errors(fitted.values / problem.scale)

    def errors_of(self, fits: Sequence[Fit]) -> Array:
        """Relative errors (fits, 9, 3) of fits of one hypothesis on this table."""
        problem = self.problem(fits[0].hypothesis)
        return problem.all_errors([f.values / problem.scale for f in fits])

    def metrics(self, fitted: Fit) -> Array:
        """Metrics (9, 3) of a fit at this table's rate."""
        problem = self.problem(fitted.hypothesis)
        return np.asarray(problem.metrics([fitted.values / problem.scale])[0])

    def reweighted(self, fitted: Fit, weights: Sequence[Array]) -> list[Fit]:
        """The fit with its parameters moved to where they would be if tests counted by ``weights``."""
        problem = self.problem(fitted.hypothesis)
        x = fitted.values / problem.scale
        points = [problem.moved(x, fitted.residual, fitted.jacobian, w) for w in weights]
        return [replace(fitted, values=problem.scale * point) for point in points]

    def _search(self, problem: TableProblem, warm: Fit | None) -> Array:
        best, least = np.zeros(0), np.inf
        for start in self._starts(problem, warm):
            errors, jacobian = problem.errors(start), problem.jacobian(start)
            step = problem.moved(start, errors, jacobian, np.ones(len(TESTS))) - start
            expected = np.sum((errors.ravel() + jacobian @ step) ** 2)
            found = [start, start + step]
            if warm is None or expected < (1.0 - SCREEN) * warm.rms**2 * errors.size:
                found.append(problem.search(start))
            for x in found:
                cost = float(np.sum(problem.errors(x) ** 2))
                if cost < least:
                    best, least = x, cost
        return best

    def _held_out(self, problem: TableProblem, x: Array, errors: Array, jacobian: Array) -> Array:
        """Squared errors (9,) of every test, the mean over the two fits that did not see it."""
        points = []
        for fold in FOLDS:
            weights = np.ones(len(TESTS))
            weights[list(fold)] = 0.0
            points.append(problem.moved(x, errors, jacobian, weights))
        losses = np.zeros(len(TESTS))
        for fold, left_out in zip(FOLDS, problem.all_errors(points)):
            losses[list(fold)] += 0.5 * np.sum(left_out[list(fold)] ** 2, axis=1)
        return losses

    def _starts(self, problem: TableProblem, warm: Fit | None) -> list[Array]:
        known = warm.by_key() if warm else {}
        pairs = list(zip(problem.keys, problem.parameters))
        base = np.array([known.get(key, p.starts[0]) for key, p in pairs]) / problem.scale
        candidates = [base]
        for i, (key, p) in enumerate(pairs):
            for value in () if key in known else p.starts[1:]:
                other = base.copy()
                other[i] = value / p.scale
                candidates.append(other)
        candidates = [problem.inside(c) for c in candidates]
        if not problem.parameters or len(candidates) == 1:
            return candidates
        costs = np.sum(problem.all_errors(candidates) ** 2, axis=(1, 2))
        order = np.argsort(costs)
        return [candidates[i] for i in (order[:2] if costs[order[0]] < costs[0] else order[:1])]


def _information(jacobian: Array, errors: Array, x: Array) -> tuple[Array, Array]:
    """Standard deviations (linearised) and the relative rise of the loss without each parameter."""
    loss = float(np.sum(errors**2))
    variance = loss / max(errors.size - x.size, 1)
    inverse = np.diag(np.linalg.pinv(jacobian.T @ jacobian, rcond=1e-10, hermitian=True))
    seen = inverse > 0.0
    importance = np.where(seen, x**2 / np.where(seen, inverse, 1.0) / loss, 0.0)
    return np.sqrt(variance * np.maximum(inverse, 0.0)), importance
