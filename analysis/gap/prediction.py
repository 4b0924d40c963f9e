"""Predictions of runs by hypotheses: in parallel, counted, and as functions of free parameters."""

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count
from typing import Any

import numpy as np

from .hypothesis import Fit, Hypothesis
from .machine import Array, Machine, RunData
from .scaled import ScaledParameters

DIVERGED = 1e6  # multiples of the signal's spread: a prediction this far off has diverged
STEP = 1e-4  # finite-difference step, in parameter scales


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
        chosen = self.runs if runs is None else runs
        tasks = []
        for point in points:
            values = dict(zip(keys, point))
            plants = {t: hypothesis.plant(self.machine, values, t) for t in _times(chosen)}
            tasks += [(run, plants[run.start]) for run in chosen]
        found = [self._held(r) for r in self.machine.predict_all(tasks, self._pool.submit)]
        self.simulations += len(tasks)
        return [found[i : i + len(chosen)] for i in range(0, len(found), len(chosen))]

    def _held(self, residual: Array) -> Array:
        """The residual, or a large constant where the prediction diverged."""
        if not np.all(np.abs(residual) < DIVERGED * self.spread):  # NaN is not, either
            return np.full_like(residual, DIVERGED * self.spread)
        return residual


def _times(runs: Sequence[RunData]) -> set[float]:
    return {run.start for run in runs}


class Problem(ScaledParameters):
    """Residuals of a hypothesis as functions of its free parameters in units of their scales."""

    def __init__(self, predictor: Predictor, hypothesis: Hypothesis) -> None:
        super().__init__(hypothesis, predictor.machine)
        self.predictor = predictor
        self.step = max([STEP, *(form.step for form in hypothesis.forms)])
        self.rough = hypothesis.rough
        self.of_effects = np.array([effect != "" for effect, _ in self.keys], dtype=bool)

    def runs(self, points: Sequence[Array], runs: Sequence[RunData] | None = None) -> list[Any]:
        """Residuals of the runs at every point."""
        scaled = [self.scale * x for x in points]
        return self.predictor.residuals(self.hypothesis, scaled, self.keys, runs)

    def flat(self, x: Array) -> Array:
        """All residuals at ``x`` in one vector."""
        return flatten(self.runs([x])[0])

    def jacobian(self, x: Array) -> Array:
        """Derivatives of ``flat`` by differences that stay inside the bounds."""
        return self.columns(x, self.flat(x), range(x.size))

    def columns(self, x: Array, residual: Array, which: Sequence[int]) -> Array:
        """Some columns of the Jacobian at ``x``, where the residual is known."""
        steps = self.steps(x, self.step)
        points = [x + steps[i] * unit for i, unit in zip(which, np.eye(x.size)[list(which)])]
        moved = [flatten(r) for r in self.runs(points)]
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


def flatten(residuals: Sequence[Array]) -> Array:
    """The residuals of all runs in one vector."""
    return np.concatenate([r.ravel() for r in residuals])
