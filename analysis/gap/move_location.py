"""Where the gap of a stepping machine lies: shares by joint, load, history, pace of change and run."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from .location import of_runs, shares
from .machine import Array

if TYPE_CHECKING:
    from .step_machine import MoveRun

REGIMES = ("after a reversal", "unloaded", "against the load", "with the load")
UNLOADED = 0.1  # load factor below which a move counts as unloaded
SLOW = 10  # changes over more moves than this are slow
BANDS: tuple[dict[str, Any], ...] = (
    {"name": f"over more than {SLOW} moves", "least_moves": SLOW, "most_moves": None},
    {"name": f"within {SLOW} moves", "least_moves": 1, "most_moves": SLOW},
)


def locate_moves(
    runs: "Sequence[MoveRun]", residuals: Sequence[Array], joints: Sequence[int], seed: int
) -> dict[str, list[dict[str, Any]]]:
    """Shares of the gap as in FORMAT.md; a sample is a move, so bands are in moves instead of Hz."""
    rng = np.random.default_rng(seed)
    squares = [r**2 for r in residuals]
    by_joint = [r * [run.joint == joint for joint in joints] for run, r in zip(runs, squares)]
    names = [f"joint_{joint + 1}" for joint in joints]
    by_regime = [_by_regime(run, square) for run, square in zip(runs, squares)]
    pace = np.sum([_by_pace(r.sum(axis=1)) for r in residuals], axis=0)
    return {
        "signals": shares([f"displacement of {name}" for name in names], by_joint, rng),
        "joints": shares(names, by_joint, rng),
        "regimes": shares(REGIMES, by_regime, rng),
        "bands": [
            {**band, "share": float(s)} for band, s in zip(BANDS, pace / (pace.sum() or 1.0))
        ],
        "runs": of_runs(runs, residuals),
    }


def _by_regime(run: "MoveRun", square: Array) -> Array:
    """Energy (moves, regimes) of exclusive regimes."""
    load = run.load.mean(axis=1)[run.window]
    reverses, positive = run.reverses[run.window], run.side[run.window] == 1
    free = np.abs(load) < UNLOADED
    against = (load > 0.0) == positive
    masks = [reverses, ~reverses & free, ~reverses & ~free & against, ~reverses & ~free & ~against]
    return np.column_stack([mask * square.sum(axis=1) for mask in masks])


def _by_pace(residual: Array) -> Array:
    """Energy of what changes slowly and of what changes from move to move, about the run as it is."""
    power = np.abs(np.fft.rfft(residual)) ** 2
    power[1:] *= 2.0
    slow = np.arange(power.size) * SLOW <= residual.size
    return np.array([power[slow].sum(), power[~slow].sum()]) / residual.size
