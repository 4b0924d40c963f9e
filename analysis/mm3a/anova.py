"""Analysis of variance of the step size: day, direction, rotation about the prismatic axis.

One-way tests (``scipy.stats.f_oneway``) as in sections 4.2, 4.4 and 5.2, each on runs that differ in nothing
but the factor. Printed p-values, joint 3: day 0.0003 and 0.001, direction 0.00004, rotation 0.4 and 0.9;
joint 2: day 0.033 and 0.016, direction 0.0000004.
"""

from collections import defaultdict
from collections.abc import Callable, Hashable, Sequence
from dataclasses import dataclass

import numpy as np
from scipy import stats

from .runs import Run

SIGNIFICANT = 0.05


@dataclass(frozen=True, kw_only=True)
class Effect:
    """One test: does the mean step of ``joint`` differ between the levels of ``factor``?"""

    factor: str  # day, direction or rotation
    joint: int
    where: str  # what the compared runs share
    levels: tuple[str, ...]
    sizes: tuple[int, ...]  # runs per level
    statistic: float  # F
    p_value: float

    @property
    def significant(self) -> bool:
        """P < 0.05, the level of the thesis."""
        return self.p_value < SIGNIFICANT


def effects(runs: Sequence[Run]) -> list[Effect]:
    """Every test that the runs allow: two levels or more with at least two runs each."""
    return [
        *_tests(runs, "day", lambda r: r.day, lambda r: (r.joint, r.direction, *_posture(r))),
        *_tests(
            runs,
            "direction",
            lambda r: f"{r.direction:+d}",
            lambda r: (r.joint, r.day, *_still_posture(r)),
        ),
        *_tests(
            [r for r in runs if r.joint == 3 and _is(r.q2, -np.pi / 2) and _is(r.psi, 0.0)],
            "rotation",
            lambda r: f"{np.degrees(r.theta):.0f} deg",
            lambda r: (r.joint, r.direction, r.day),
        ),
    ]


def _tests(
    runs: Sequence[Run],
    factor: str,
    level: Callable[[Run], str],
    shared: Callable[[Run], tuple[Hashable, ...]],
) -> list[Effect]:
    cells: dict[tuple[Hashable, ...], dict[str, list[float]]] = defaultdict(
        lambda: defaultdict(list)
    )
    for run in runs:
        cells[shared(run)][level(run)].append(run.mean_step)
    found = []
    for key, by_level in cells.items():
        usable = {name: values for name, values in by_level.items() if len(values) > 1}
        if len(usable) < 2:
            continue
        test = stats.f_oneway(*usable.values())
        found.append(
            Effect(
                factor=factor,
                joint=int(str(key[0])),
                where=", ".join(str(part) for part in key[1:]),
                levels=tuple(usable),
                sizes=tuple(len(values) for values in usable.values()),
                statistic=float(test.statistic),
                p_value=float(test.pvalue),
            )
        )
    return found


def _posture(run: Run) -> tuple[str, ...]:
    """Start, target and tilt, as text that rounding cannot tell apart."""
    values = {"q1": run.q1, "q2": run.q2, "q3": run.q3, "theta": run.theta, "psi": run.psi}
    return (*(f"{name} {value:.6g}" for name, value in values.items()), f"to {run.target:.6g}")


def _still_posture(run: Run) -> tuple[str, ...]:
    """The same without direction: where the moving joint is between, in either order."""
    low, high = sorted((run.start, run.target))
    still = [part for part in _posture(run)[:-1] if not part.startswith(f"q{run.joint} ")]
    return (*still, f"{low:.6g} to {high:.6g}")


def _is(value: float, expected: float) -> bool:
    return abs(value - expected) < 1e-6
