"""How far the gap shrinks, on runs that were never used to fit or to choose."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import bootstrap
from .floor import MEASURED
from .hypothesis import Fit, Hypothesis
from .machine import Array, Machine, RunData
from .prediction import Predictor

BLOCKS = 20  # per run
RESAMPLES = 1000
LEVELS = ("before", "retuned", "after", "floor")
Interval = tuple[float, float]
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
    intervals: Mapping[str, Interval | None]  # 95 %, of before, retuned, after and floor
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
    """Before, retuned, after and floor, each and the percent with a block-bootstrap interval.

    ``logged`` are the validation runs as they came, ``runs`` the same with wrong signals corrected:
    before is the nominal model on the former, all else is on the latter. A floor that was not measured
    from repeated cycles has no interval.
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
    parts = {
        name: bootstrap.energies(
            [machine.unexplained(r, run) for r, run in zip(kind, runs)], BLOCKS
        )
        for name, kind in zip(LEVELS, (raw, tuned, after, floors))
    }
    before, retuned_rms, after_rms, floor = (_rms(*part) for part in parts.values())
    measured = source.startswith(MEASURED)
    percent, interval = _percent(
        parts["before"], parts["after"], parts["floor"], seed if measured else None, seed
    )
    command = np.concatenate([run.command[run.window].ravel() for run in runs])
    return Shrinkage(
        metric=machine.metric,
        before=before,
        retuned=retuned_rms,
        after=after_rms,
        floor=floor,
        percent=percent,
        ci95=interval,
        intervals={
            name: None if name == "floor" and not measured else _interval(*part, seed)
            for name, part in parts.items()
        },
        relative_to_command=float(np.sqrt(np.mean(command**2))),
        floor_source=source,
        runs=tuple(run.name for run in runs),
    )


def _percent(
    before: tuple[Array, Array],
    after: tuple[Array, Array],
    floor: tuple[Array, Array],
    floor_seed: int | None,
    seed: int,
) -> tuple[float | None, Interval | None]:
    """100 (before - after) / (before - floor) and its interval; None where no gap surely is there.

    The floor is resampled as well, unless ``floor_seed`` is None: one that was computed has no sampling error.
    """
    top, least = _rms(*before), _rms(*floor)
    draws = _draws(len(before[0]), seed)
    b, a = bootstrap.resampled_rms(*before, draws), bootstrap.resampled_rms(*after, draws)
    f = np.full(RESAMPLES, least)
    if floor_seed is not None:
        f = bootstrap.resampled_rms(*floor, _draws(len(floor[0]), floor_seed + 1))
    if min(top, float(np.quantile(b, 0.025))) <= SURE * max(least, float(np.quantile(f, 0.975))):
        return None, None
    sampled = 100.0 * (b - a) / np.maximum(b - f, (SURE - 1.0) * f)
    low, high = bootstrap.interval(sampled)
    return float(100.0 * (top - _rms(*after)) / (top - least)), (float(low), float(high))


def _interval(energy: Array, count: Array, seed: int) -> Interval:
    """95 % interval of the rms."""
    sampled = bootstrap.resampled_rms(energy, count, _draws(len(energy), seed))
    low, high = bootstrap.interval(sampled)
    return float(low), float(high)


def _draws(blocks: int, seed: int) -> NDArray[np.int64]:
    return bootstrap.draws(blocks, RESAMPLES, np.random.default_rng(seed))


def _rms(energy: Array, count: Array) -> float:
    return float(np.sqrt(energy.sum() / count.sum()))
