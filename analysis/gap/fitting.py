"""Fit hypotheses to runs by prediction error, and judge them on runs they were not fitted to.

The residual is that of the machine's ``predict``: the model is driven by the logged command and says
what will be measured one sample later. It needs no model of the controller, keeps the whole
frequency content of the log and is white where the model is right (Ljung 1999, ch. 7).
"""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from .hypothesis import Fit, Hypothesis
from .machine import Array
from .prediction import Predictor, Problem, flatten
from .search import search

SCREEN = 0.004  # a form whose linearised loss falls by less than this share is not pursued
MOST_STEPS = 20  # of a least-squares search
FIRST_STEPS = 4  # of a search that is only taken further where it leads somewhere
BLOCKS = 30  # blocks of a run whose losses are resampled together
FEW_RUNS = 2  # up to this many are held out by stretches of time, not whole
FOLDS = 4  # stretches of such a run
PARTS_OF_STEP = 1.0, 0.5, 0.25, 0.125, 0.0  # of a Gauss-Newton step without a piece
DOUBTFUL = 1.1  # ratio of the loss of a held-out piece to that of the same piece fitted


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
    problem = Problem(predictor, hypothesis)
    x, jac, searched, finished = search(problem, warm, screen, steps)
    final = problem.runs([x])[0]
    span = np.minimum(problem.upper - problem.lower, 1.0)
    at_bound = (x - problem.lower < 1e-4 * span) | (problem.upper - x < 1e-4 * span)
    residual = flatten(final)
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


def block_losses(residuals: Sequence[Array]) -> tuple[Array, Array]:
    """Squared residuals summed over blocks of every run, and the number of values in each block."""
    pieces = [piece for r in residuals for piece in np.array_split(r, min(BLOCKS, len(r)), axis=0)]
    return np.array([np.sum(p**2) for p in pieces]), np.array([float(p.size) for p in pieces])


def _held_out(
    problem: Problem, final: Sequence[Array], jac: Array, x: Array, at_bound: Array
) -> list[Array]:
    """Residuals of every piece at parameters that did not see it.

    The parameters without a piece are one Gauss-Newton step from the full solution, the piece is then
    predicted in full. A step that predicts it much worse is shortened until it helps the others, as a step that
    fits them does. A piece is a run, or a stretch of time where runs are few: one of two runs may be the
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
        for part in PARTS_OF_STEP:
            point = np.clip(x + part * step, problem.lower, problem.upper)
            there = problem.runs([point], [problem.predictor.runs[run]])[0][0][piece]
            held_out[run][piece] = there
            if np.sum(there**2) < DOUBTFUL * np.sum(final[run][piece] ** 2):
                break
            if _loss_without(problem.runs([point])[0], run, piece) <= _loss_without(
                final, run, piece
            ):
                break
    return held_out


def _loss_without(residuals: Sequence[Array], run: int, piece: slice) -> float:
    """Squared residuals of all but one piece of a run."""
    return float(sum(np.sum(r**2) for r in residuals) - np.sum(residuals[run][piece] ** 2))


def _information(problem: Problem, jac: Array, residual: Array, x: Array) -> tuple[Array, Array]:
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
