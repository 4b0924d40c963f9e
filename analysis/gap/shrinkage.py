"""How far the gap shrinks, on runs that were never used to fit or to choose."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .fitting import Predictor
from .hypothesis import Fit, Hypothesis
from .machine import Array, Machine, RunData, rms

BLOCKS = 20  # per run
RESAMPLES = 1000
SURE = 1.05  # ratio to the floor from which on there is a gap to take a share of


@dataclass(frozen=True, kw_only=True)
class Shrinkage:
    """Rms unexplained effort on the validation runs, four times, and what follows from it."""

    metric: str
    before: float
    retuned: float
    after: float
    floor: float
    percent: float | None
    ci95: tuple[float, float] | None
    relative_to_command: float  # rms command on the same samples
    floor_source: str
    runs: tuple[str, ...]


def shrinkage(
    machine: Machine,
    logged: Sequence[RunData],
    runs: Sequence[RunData],
    retuned: Fit,
    chosen: Fit,
    seed: int,
) -> Shrinkage:
    """Before, retuned, after and floor, with a block-bootstrap interval of the percent.

    ``logged`` are the validation runs as they came, ``runs`` the same with wrong signals corrected:
    before is the nominal model on the former, all else is on the latter.
    """
    nominal = machine.nominal()
    names = tuple(("", name) for name in nominal)
    raw = Predictor(machine, logged).residuals(
        Hypothesis(), [np.array(list(nominal.values()))], names
    )[0]
    predictor = Predictor(machine, runs)
    tuned = predictor.residuals(retuned.hypothesis, [retuned.values], retuned.keys)[0]
    after = predictor.residuals(chosen.hypothesis, [chosen.values], chosen.keys)[0]
    floors, source = machine.floor(runs, after)
    parts = [
        _blocks([machine.unexplained(r, run) for r, run in zip(kind, runs)])
        for kind in (raw, tuned, after)
    ]
    floor = rms([machine.unexplained(f, run) for f, run in zip(floors, runs)])
    before, retuned_rms, after_rms = (_rms(energy, count) for energy, count in parts)
    percent, interval = _percent(parts[0], parts[2], floor, seed)
    command = np.concatenate([run.command[run.window].ravel() for run in runs])
    return Shrinkage(
        metric=machine.metric,
        before=before,
        retuned=retuned_rms,
        after=after_rms,
        floor=floor,
        percent=percent,
        ci95=interval,
        relative_to_command=float(np.sqrt(np.mean(command**2))),
        floor_source=source,
        runs=tuple(run.name for run in runs),
    )


def _percent(
    before: tuple[Array, Array], after: tuple[Array, Array], floor: float, seed: int
) -> tuple[float | None, tuple[float, float] | None]:
    """100 (before - after) / (before - floor) and its interval; None where no gap surely is there."""
    top = _rms(*before)
    rng = np.random.default_rng(seed)
    draws = rng.integers(0, len(before[0]), (RESAMPLES, len(before[0])))
    b = np.sqrt(before[0][draws].sum(axis=1) / before[1][draws].sum(axis=1))
    a = np.sqrt(after[0][draws].sum(axis=1) / after[1][draws].sum(axis=1))
    if min(top, float(np.quantile(b, 0.025))) <= SURE * floor:
        return None, None
    sampled = 100.0 * (b - a) / np.maximum(b - floor, (SURE - 1.0) * floor)
    low, high = np.quantile(sampled, [0.025, 0.975])
    return float(100.0 * (top - _rms(*after)) / (top - floor)), (float(low), float(high))


def _blocks(values: Sequence[Array]) -> tuple[Array, Array]:
    pieces = [p for v in values for p in np.array_split(v, BLOCKS, axis=0)]
    return np.array([np.sum(p**2) for p in pieces]), np.array([float(p.size) for p in pieces])


def _rms(energy: Array, count: Array) -> float:
    return float(np.sqrt(energy.sum() / count.sum()))
