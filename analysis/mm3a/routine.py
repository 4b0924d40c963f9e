r"""The calibration routine of chapter 6: each parameter from one measurement, in sequence.

1. :math:`a = \bar\gamma_{level}`, :math:`b = 1 - \bar\gamma_{folded}/a`, :math:`c = a - \bar\gamma_{up}/(1 - b)`    (6.2-6.4)
2. rotary :math:`d` by repeated simulation of the run                                  (algorithm)
3. rotary :math:`d` by a quadratic in :math:`\Delta = \bar\gamma_{loaded} - \bar\gamma_{free}`              (6.6)

What (6.6) means. Printed as :math:`3.41\Delta^2 + 0.025\Delta + 6.42\cdot10^{-7}` it gives, in rad or in urad,
no d of Fig. 5.6. Refitting the algorithm over the stated range (free steps of 75-115 urad, :math:`|\Delta|
\le 9.2` urad) gives :math:`3.64\cdot10^4\Delta^2 + 2.46\Delta - 2\cdot10^{-8}` in rad: the printed
coefficients are those for :math:`\Delta` in units of 0.01 rad and d in rad. Then they agree to 7 % and 2 %, and the
printed constant is a bias of 0.64 urad at zero load. In first order :math:`\Delta = 0.4135 d`, the
mean of sin over the range of the joint. The quadratic holds within the range it was fitted on; the run
with the extended arm (d = 23.94 urad) is at its edge.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import integrate, optimize

from ...models.mm3a.arm import Arm
from ...models.mm3a.step_size import PrismaticStep, RotaryStep
from ..errors import InputError
from .runs import Run

# Range of zeta = -q2 over which joint 2 is driven [rad].
ZETA = (-np.pi / 6.0, 7.0 * np.pi / 6.0)
ITERATIONS = 5  # of the algorithm, as printed
PRINTED = (3.41e4, 2.5, 6.42e-7)  # (6.6) for Delta and d in rad: 1/rad, -, rad
FREE_STEPS = (75e-6, 115e-6)  # free steps over which (6.6) was fitted [rad]
FIT_RANGE = 9.2e-6  # |Delta| over which (6.6) was fitted [rad]


def prismatic_by_routine(level: float, folded: float, upright: float) -> PrismaticStep:
    """Equations (1): mean steps at (q2, theta) = (-pi/2, 0), (0, -pi/2), (0, 0) [m]."""
    recoil = 1.0 - folded / level
    return PrismaticStep(basic=level, recoil=recoil, load=level - upright / (1.0 - recoil))


def mean_loaded_step(free: float, load: float) -> float:
    """Exact mean step [rad] over the range of joint 2, range / integral(d zeta / gamma)."""
    time, _ = integrate.quad(lambda zeta: 1.0 / (free + load * np.sin(zeta)), *ZETA)
    return (ZETA[1] - ZETA[0]) / time


def load_exactly(free: float, loaded: float) -> float:
    """The d [rad] whose exact mean step is ``loaded``. ValueError if no |d| < free has it."""
    bound = 0.999 * free
    low, high = mean_loaded_step(free, -bound), mean_loaded_step(free, bound)
    if not low < loaded < high:
        raise ValueError(
            f"a mean loaded step of {loaded} rad beside a free one of {free} rad; expected between "
            f"{low} and {high} rad"
        )
    return float(
        optimize.brentq(
            lambda load: mean_loaded_step(free, load) - loaded, -bound, bound, xtol=1e-18
        )
    )


@dataclass(frozen=True, kw_only=True)
class Iteration:
    """Result of the algorithm of section 6.2."""

    load: float  # d [rad]
    errors: NDArray[np.float64]  # (iterations,) mean step measured less simulated [rad]


def load_by_iteration(
    free: float, loaded: float, guess: float | None = None, iterations: int = ITERATIONS
) -> Iteration:
    """Algorithm of section 6.2 line by line: simulate the run, scale d, repeat.

    Lines 12 and 13, arcsine and sine of the same ratio, amount to d (loaded - free)/(simulated - free).
    Convergence is linear, about sixfold per iteration for the extended arm: five of them reach the printed
    1e-11 rad for differences up to some 1 urad, and 1e-8 rad at 9.2 urad - then still 1e-4 of d.
    Raises ValueError if an iterate exceeds the free step, as it does for loads far beyond Fig. 5.6.
    """
    load = guess if guess is not None else loaded - free
    errors = []
    for _ in range(iterations):
        if not abs(load) < free:
            raise ValueError(
                f"the iteration for d passes {load} rad beside a free step of {free} rad, at which the "
                "simulated joint stands still; expected |d| < free: use the exact method"
            )
        zeta, total, count = ZETA[0], 0.0, 0
        while zeta <= ZETA[1]:
            step = free + load * np.sin(zeta)
            total += step
            count += 1
            zeta += step
        simulated = total / count
        errors.append(loaded - simulated)
        load = load * (loaded - free) / (simulated - free) if simulated != free else 0.0
    return Iteration(load=load, errors=np.array(errors))


def load_by_quadratic(free: float, loaded: float, coefficients: Sequence[float] = PRINTED) -> float:
    """Equation (6.6) in rad, see the module for its units."""
    return float(np.polyval(coefficients, loaded - free))


def refit_quadratic(points: int = 41) -> tuple[NDArray[np.float64], float]:
    """Refit (6.6) to exact solutions over its stated range: coefficients [rad], largest error [rad]."""
    pairs = [
        (difference, load_exactly(free, free + difference))
        for free in np.linspace(*FREE_STEPS, 9)
        for difference in np.linspace(-FIT_RANGE, FIT_RANGE, points)
    ]
    difference, load = np.array(pairs).T
    # Fitted in urad: the squares of rad are too small for the conditioning of polyfit.
    in_urad = np.polyfit(difference * 1e6, load * 1e6, 2)
    error = np.abs(np.polyval(in_urad, difference * 1e6) - load * 1e6).max() * 1e-6
    return in_urad * np.array([1e6, 1.0, 1e-6]), float(error)


METHODS: dict[str, Callable[[float, float], float]] = {
    "iteration": lambda free, loaded: load_by_iteration(free, loaded).load,
    "printed": load_by_quadratic,
    "exact": load_exactly,
}


def rotary_by_routine(
    means: dict[tuple[float, bool], float], method: str = "iteration"
) -> RotaryStep:
    """Rotary parameters from four mean steps [rad], keyed by (q3 [m], loaded by gravity).

    ``method`` is iteration, printed (6.6) or exact; ValueError for another.
    """
    if method not in METHODS:
        raise ValueError(f"unknown method {method!r}; expected one of {', '.join(METHODS)}")
    ends = sorted({q3 for q3, _ in means})
    loads = [METHODS[method](means[q3, False], means[q3, True]) for q3 in ends]
    return RotaryStep(
        basic_retracted=means[ends[0], False],
        basic_extended=means[ends[-1], False],
        load_retracted=loads[0],
        load_extended=loads[-1],
    )


def calibrate_by_routine(
    runs: Sequence[Run], joint: int, direction: int, method: str = "iteration"
) -> PrismaticStep | RotaryStep:
    """Chapter 6 for one joint and direction from the runs that match its configurations, averaged.

    The sign of d for joint 1 follows its load factor, which is negative at theta = -pi/2. InputError if a
    configuration of Fig. 6.1 or 6.3 has not been measured.
    """
    chosen = [run for run in runs if (run.joint, run.direction) == (joint, direction)]
    if joint == 3:
        level, folded, upright = (
            _mean(chosen, {"q2": q2, "theta": theta})
            for q2, theta in ((-np.pi / 2, 0.0), (0.0, -np.pi / 2), (0.0, 0.0))
        )
        return prismatic_by_routine(level, folded, upright)
    loaded_theta, free_theta = (0.0, -np.pi / 2) if joint == 2 else (-np.pi / 2, 0.0)
    means = {
        (q3, loaded): _mean(chosen, {"q3": q3, "theta": loaded_theta if loaded else free_theta})
        for q3 in (Arm().lower_3, Arm().upper_3)
        for loaded in (False, True)
    }
    result = rotary_by_routine(means, method)
    if joint == 1:
        return RotaryStep(
            basic_retracted=result.basic_retracted,
            basic_extended=result.basic_extended,
            load_retracted=-result.load_retracted,
            load_extended=-result.load_extended,
        )
    return result


def _mean(runs: Sequence[Run], configuration: dict[str, float]) -> float:
    """Mean step of the runs at a configuration, over the full range of their joint."""
    arm = Arm()
    found = [
        run.distance / run.steps
        for run in runs
        if all(abs(getattr(run, name) - value) < 1e-6 for name, value in configuration.items())
        and abs(run.psi) < 1e-6
        and run.distance > 0.99 * (arm.upper[run.joint - 1] - arm.lower[run.joint - 1])
    ]
    if not found:
        where = ", ".join(f"{name} = {value:.4g}" for name, value in configuration.items())
        raise InputError(
            "runs",
            f"none covers the full range at {where}, psi = 0",
            "the calibrating configurations of Figs. 6.1 and 6.3",
        )
    return float(np.mean(found))
