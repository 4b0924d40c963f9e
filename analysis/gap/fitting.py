"""Fit hypotheses to runs by prediction error, and judge them on runs they were not fitted to.

The residual is that of the machine's ``predict``: the model is driven by the logged command and says
what will be measured one sample later. It needs no model of the controller, keeps the whole
frequency content of the log and is white where the model is right (Ljung 1999, ch. 7).
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from .bootstrap import energies
from .hypothesis import Fit, Hypothesis
from .machine import Array
from .prediction import Predictor, Problem, flatten
from .search import refit, search

SCREEN = 0.004  # a form whose linearised loss falls by less than this share is not pursued
MOST_STEPS = 20  # of a least-squares search
FIRST_STEPS = 4  # of a search that is only taken further where it leads somewhere
BLOCKS = 30  # blocks of a run whose losses are resampled together
FEW_RUNS = 2  # up to this many are held out by stretches of time, not whole
FOLDS = 4  # stretches of such a run
PARTS_OF_STEP = (
    0.5,
    0.25,
    0.125,
)  # of a Gauss-Newton step without a piece that does not help the others
REFIT_STEPS = 6  # of a search without a piece, where no such part helps
ROUNDING = 1e-9  # relative rise of a loss that is none


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
    step leads and not searched further; its held-out losses are those of ``warm``, scaled by that gain, unless the
    search for ``warm`` has not ended: held-out parameters, a step further, are far better than its own then.
    ``steps`` bounds the search; a fit that used them all is not ``finished``.
    """
    problem = Problem(predictor, hypothesis)
    x, jac, searched, finished = search(problem, warm, screen, steps)
    final = problem.runs([x])[0]
    span = np.minimum(problem.upper - problem.lower, 1.0)
    at_bound = (x - problem.lower < 1e-4 * span) | (problem.upper - x < 1e-4 * span)
    residual = flatten(final)
    if searched or warm is None or not warm.finished:
        losses, samples = energies(_held_out(problem, final, jac, x, at_bound), BLOCKS)
    else:  # it is as good on held-out runs as its parent, but for the little it gained on fit runs
        losses, samples = warm.losses * np.mean(residual**2) / warm.rms**2, warm.samples
    held_out = float(np.sqrt(losses.sum() / samples.sum()))
    spread = predictor.machine.spread(predictor.runs)
    variance = _variance(final, x.size)
    deviation, importance = _information(problem, jac, residual, x, variance)
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
        searched=searched or warm is None,
    )


def _held_out(
    problem: Problem, final: Sequence[Array], jac: Array, x: Array, at_bound: Array
) -> list[Array]:
    """Residuals of every piece at parameters that did not see it.

    The parameters without a piece are one Gauss-Newton step from the full solution, the piece is then
    predicted in full. A step that fits the others worse is shortened until it does not; where none helps, a short
    search without the piece starts from the full solution.
    A piece is a run, or a stretch of time where runs are few: one of two runs may be the
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
    residual = flatten(final)
    active = np.logical_not(at_bound)
    # Directions that the data leave free stay inside the bounds by their prior, as in ``_information``.
    variance = _variance(final, x.size)
    prior = variance * 12.0 / np.square(problem.upper - problem.lower)[active]
    ridge = np.diag(prior + 1e-9 * max(float(np.sum(jac**2)), 1e-300))
    hessian, gradient = jac[:, active].T @ jac[:, active], jac[:, active].T @ residual
    steps = np.zeros((len(pieces), x.size))
    rows = [slice(starts[i] + n * p.start, starts[i] + n * p.stop) for i, p in pieces]
    for step, seen in zip(steps, rows):
        J = jac[seen][:, active]
        step[active] = -np.linalg.solve(hessian - J.T @ J + ridge, gradient - J.T @ residual[seen])
    points = np.clip(x + steps, problem.lower, problem.upper)
    held_out = [np.array(r) for r in final]
    for (run, piece), step, seen, whole in zip(pieces, steps, rows, problem.runs(list(points))):
        found = _without_piece(problem, final, x, step, (run, piece), seen, whole)
        held_out[run][piece] = found[run][piece]
    return held_out


def _without_piece(
    problem: Problem,
    final: Sequence[Array],
    x: Array,
    step: Array,
    piece: tuple[int, slice],
    rows: slice,
    whole: Sequence[Array],
) -> Sequence[Array]:
    """Residuals of all runs at parameters that did not see a piece; ``whole`` are those after the whole ``step``.

    What the piece itself becomes decides nothing. Beside impacts, where slopes may mislead, the full solution ``x`` is
    kept when no part of the step helps the others.
    """
    least = _loss_without(final, *piece) * (1.0 + ROUNDING)
    if _loss_without(whole, *piece) <= least:
        return whole
    for part in PARTS_OF_STEP:
        point = np.clip(x + part * step, problem.lower, problem.upper)
        there = problem.runs([point])[0]
        if _loss_without(there, *piece) <= least:
            return list(there)
    if problem.rough:
        return final
    return list(problem.runs([refit(problem, x, rows, REFIT_STEPS)])[0])


def _loss_without(residuals: Sequence[Array], run: int, piece: slice) -> float:
    """Squared residuals of all but one piece of a run."""
    return float(sum(np.sum(r**2) for r in residuals) - np.sum(residuals[run][piece] ** 2))


def _information(
    problem: Problem, jac: Array, residual: Array, x: Array, variance: float
) -> tuple[Array, Array]:
    """Standard deviations and importances from the Gauss-Newton Hessian.

    Samples count as far as the residual is uncorrelated; a bounded parameter has a uniform prior.
    """
    if x.size == 0:
        return np.zeros(0), np.zeros(0)
    loss = max(float(residual @ residual), 1e-300)
    prior = 12.0 / np.square(problem.upper - problem.lower)
    hessian = jac.T @ jac
    spread = np.diag(np.linalg.pinv(hessian / variance + np.diag(prior), hermitian=True))
    conditional = np.diag(np.linalg.pinv(hessian, rcond=1e-12, hermitian=True))
    seen = conditional > 0.0
    importance = np.where(seen, x**2 / np.where(seen, conditional, 1.0) / loss, 0.0)
    return np.sqrt(np.maximum(spread, 0.0)), importance


def _variance(residuals: Sequence[Array], parameters: int) -> float:
    """Variance of one independent sample's worth of the residuals (samples, n) of some runs."""
    columns = np.concatenate(residuals)
    loss = max(float(np.sum(columns**2)), 1e-300)
    return loss / max(effective_samples(columns), parameters + 1.0)


def effective_samples(residual: Array) -> float:
    """Number of independent values worth of a residual (samples, n) correlated in time.

    Columns are counted one by one: interleaved they would look uncorrelated.
    """
    return float(sum(_effective(column) for column in residual.T))


def _effective(residual: Array) -> float:
    """``effective_samples`` of one column (initial positive sequence)."""
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
