r"""Step parameters by maximum likelihood from all runs, with intervals.

1. :math:`\ln\bar\gamma_k = \ln\mu_k(p) + \delta_{day(k)} + \epsilon_k`, :math:`\epsilon_k \sim N(0, \sigma^2)`
2. :math:`\mu_k = R_k / \int dq/\gamma(q; p)` along the run

Each joint and direction is its own fit. Unlike the routine of chapter 6 it uses every run - partial ranges
(sections 5.3, 6.2), any tilt, several days - the exact mean (2) instead of the mean step, and repeats. Days
other than the first have a factor :math:`e^\delta`; parameters are those of the first day. Intervals are
:math:`t_{0.975}` times the standard error of the linearised fit: exact in the basic step, first order in the
others.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import optimize, stats

from ...models.mm3a import step_size
from ...models.mm3a.arm import Arm
from ...models.mm3a.step_size import PrismaticStep, RotaryStep
from ..errors import InputError
from .runs import Run, mean_of_inverse

NAMES = {
    3: ("basic", "recoil", "load"),
    2: ("basic_retracted", "basic_extended", "load_retracted", "load_extended"),
}
NAMES[1] = NAMES[2]
CONFIDENCE = 0.95


@dataclass(frozen=True, kw_only=True)
class Estimate:
    """Parameters of one joint and direction with the half widths of their 95 % intervals."""

    joint: int  # 1, 2, 3
    direction: int  # -1, 1
    names: tuple[str, ...]
    values: NDArray[np.float64]
    half_widths: NDArray[np.float64]  # inf where there is no run to spare
    scatter: float  # sigma, relative, from run to run; nan without a run to spare
    freedom: int  # runs less parameters
    days: dict[str, tuple[float, float]]  # factor over the first day and its half width

    def step(self) -> PrismaticStep | RotaryStep:
        """The parameters as a step of the model; ValueError if the fit left its range."""
        kind: Any = PrismaticStep if self.joint == 3 else RotaryStep
        return kind(**dict(zip(self.names, map(float, self.values))))


def estimate(runs: Sequence[Run], joint: int, direction: int, arm: Arm | None = None) -> Estimate:
    """Fit (1) to the runs of ``joint`` in ``direction``.

    InputError if they leave a parameter undetermined, naming it.
    """
    arm = arm or Arm()
    chosen = [run for run in runs if (run.joint, run.direction) == (joint, direction)]
    days = sorted({run.day for run in chosen})
    names = NAMES[joint]
    if len(chosen) < len(names) + len(days) - 1:
        raise InputError(
            f"runs of joint {joint}, direction {direction:+d}",
            f"{len(chosen)} runs for {len(names)} parameters and {len(days)} days",
            "at least as many runs as parameters plus days less one",
        )
    problem = _Problem(chosen, names, days, arm)
    fit: Any = optimize.least_squares(problem.residuals, problem.start(), x_scale="jac", xtol=1e-14)
    problem.check_rank(np.asarray(fit.jac), joint, direction)
    return problem.estimate(fit, joint, direction)


class _Problem:
    """Residuals of one fit; parameters in units of the mean step, shares as they are."""

    def __init__(
        self, runs: Sequence[Run], names: tuple[str, ...], days: list[str], arm: Arm
    ) -> None:
        self.names, self.days, self.joint = names, days, runs[0].joint
        self.measured = np.log([run.mean_step for run in runs])
        self.unit = float(np.exp(self.measured.mean()))
        self.postures = [run.postures() for run in runs]
        self.loads = [run.loads(arm) for run in runs]
        self.travel = arm.upper_3 - arm.lower_3
        self.is_day = np.array([[run.day == day for day in days[1:]] for run in runs], dtype=float)

    def units(self) -> NDArray[np.float64]:
        return np.array([1.0 if name == "recoil" else self.unit for name in self.names])

    def start(self) -> NDArray[np.float64]:
        parameters = [1.0 if "basic" in name else 0.0 for name in self.names]
        return np.array(parameters + [0.0] * (len(self.days) - 1))

    def residuals(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        p = x[: len(self.names)] * self.units()
        predicted = [
            mean_of_inverse(np.maximum(self._sizes(q, load, p), 1e-3 * self.unit))
            for q, load in zip(self.postures, self.loads)
        ]
        return self.measured - np.log(predicted) - self.is_day @ x[len(self.names) :]

    def _sizes(
        self, q: NDArray[np.float64], load: NDArray[np.float64], p: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        if self.joint == 3:
            return step_size.prismatic_step(q[:, 1], load, p[0], p[1], p[2])
        return step_size.rotary_step(q[:, 2], load, p[0], p[1], p[2], p[3], self.travel)

    def check_rank(self, jacobian: NDArray[np.float64], joint: int, direction: int) -> None:
        _, singular, rows = np.linalg.svd(jacobian)
        if singular[-1] > 1e-6 * singular[0]:
            return
        labels = [*self.names, *(f"factor of {day}" for day in self.days[1:])]
        loose = [name for name, share in zip(labels, np.abs(rows[-1])) if share > 0.1]
        raise InputError(
            f"runs of joint {joint}, direction {direction:+d}",
            f"they leave {' and '.join(loose)} undetermined",
            "runs at different loads, elbow angles and extensions, as in Figs. 6.1 and 6.3",
        )

    def estimate(self, fit: Any, joint: int, direction: int) -> Estimate:
        freedom = self.measured.size - fit.x.size
        variance = 2.0 * fit.cost / freedom if freedom else np.inf
        spread = np.diag(np.linalg.inv(fit.jac.T @ fit.jac))
        quantile = stats.t.ppf(0.5 + 0.5 * CONFIDENCE, freedom) if freedom else 1.0
        widths = quantile * np.sqrt(spread * variance)
        n = len(self.names)
        factors = np.exp(fit.x[n:])
        return Estimate(
            joint=joint,
            direction=direction,
            names=self.names,
            values=fit.x[:n] * self.units(),
            half_widths=widths[:n] * self.units(),
            scatter=float(np.sqrt(variance)) if freedom else np.nan,
            freedom=freedom,
            days={
                day: (float(f), float(f * w))
                for day, f, w in zip(self.days[1:], factors, widths[n:])
            },
        )
