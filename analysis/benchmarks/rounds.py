"""Interleaved rounds: every contender once a round, so that a busy machine hits all of them alike.

A round's time of a contender is the mean over as many runs as fill ``BLOCK`` seconds, at least one.
Ratios are formed within a round; their quantiles are the spread that is reported.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

BLOCK = 0.01  # [s] a round spends on one contender, at least
QUANTILES = (0.1, 0.9)


@dataclass(frozen=True, kw_only=True)
class Contender:
    """One way to do the task: ``run`` does it once, from the same inputs each time."""

    name: str
    run: Callable[[], Any]


@dataclass(frozen=True, kw_only=True)
class Skipped:
    """A contender that this machine cannot run, and why."""

    name: str
    reason: str


@dataclass(frozen=True, kw_only=True)
class Row:
    """One contender's times [s] and their ratio to the reference contender's of the same round."""

    name: str
    median_s: float
    low_s: float  # quantile 0.1
    high_s: float  # quantile 0.9
    ratio: float | None  # median of the ratios within a round; None without a reference
    ratio_low: float | None  # quantile 0.1
    ratio_high: float | None  # quantile 0.9
    repeats: int  # runs that one round averages
    check: str  # what was compared, in words
    agrees: bool


@dataclass(frozen=True, kw_only=True)
class Group:
    """What one group measured."""

    name: str
    task: str
    rounds: int
    reference: str | None  # name of the contender that the ratios are to
    agreement: str  # what agreement means, with its tolerance
    rows: tuple[Row, ...]
    skipped: tuple[Skipped, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain values for ``bench.json``."""
        return asdict(self)


def measure(
    contenders: Sequence[Contender], rounds: int, clock: Callable[[], float] = time.perf_counter
) -> tuple[NDArray[np.float64], list[int]]:
    """Seconds per run (rounds, contenders) and the runs that a round averaged for each contender.

    Each contender has run at least once before, untimed. The order rotates from round to round.
    """
    repeats = [_repeats(contender.run, clock) for contender in contenders]
    seconds = np.zeros((rounds, len(contenders)))
    for k in range(rounds):
        for place in range(len(contenders)):
            j = (place + k) % len(contenders)
            run = contenders[j].run
            started = clock()
            for _ in range(repeats[j]):
                run()
            seconds[k, j] = (clock() - started) / repeats[j]
    return seconds, repeats


def _repeats(run: Callable[[], Any], clock: Callable[[], float]) -> int:
    started = clock()
    run()
    return max(1, math.ceil(BLOCK / max(clock() - started, 1e-9)))


def rows(
    contenders: Sequence[Contender],
    seconds: NDArray[np.float64],
    repeats: Sequence[int],
    checks: Sequence[tuple[str, bool]],
    reference: str | None,
) -> tuple[Row, ...]:
    """Medians, quantiles and ratios of ``seconds`` (rounds, contenders), with each one's check."""
    names = [contender.name for contender in contenders]
    base = seconds[:, names.index(reference)] if reference in names else None
    found = []
    for j, name in enumerate(names):
        low, high = np.quantile(seconds[:, j], QUANTILES)
        ratio: tuple[float | None, ...] = (None, None, None)
        if base is not None:
            ratios = seconds[:, j] / base
            ratio = tuple(float(q) for q in np.quantile(ratios, (0.5, *QUANTILES)))
        found.append(
            Row(
                name=name,
                median_s=float(np.median(seconds[:, j])),
                low_s=float(low),
                high_s=float(high),
                ratio=ratio[0],
                ratio_low=ratio[1],
                ratio_high=ratio[2],
                repeats=repeats[j],
                check=checks[j][0],
                agrees=checks[j][1],
            )
        )
    return tuple(found)
