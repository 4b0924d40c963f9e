r"""Exciting motions: Fourier series inside the limits with a small condition number (Roldan, section 5.3).

Position, speed and acceleration are (5.32)-(5.34); a machine that is ``at_rest`` has cycles that start and end without
speed and acceleration, any other enters its first cycle on the move, as the source's do. A motion beyond the limits of
position, speed or acceleration of an axis is scaled down to them; what leaves the polygon of the joint space, or where
the machine has no posture, is penalised. Three searches share this objective: compass (pattern) search, differential
evolution and CMA-ES; the gradient search has the limits as constraints.

Condition numbers after at most 3000 evaluations from seed 0 (``gapscope identify MACHINE --methods gradient,pattern,cma
--budget 3000``), measured on 2026-11-26; the compass search ended by itself after 670 to 2118:

| machine | gradient | pattern | CMA-ES |
|---|---|---|---|
| 5R | 10.27 | 35.75 | 12.65 |
| RePlaLink (printed 62.21) | 8.12 | 11.48 | 8.79 |
| 2PRU-1PRS table | 192 | 329 | 208 |
| 3-PRS | 1.13e6 | 1.34e6 | 1.12e6 |
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import scipy.optimize
import scipy.special
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

from ...models import fourier_motion
from ..errors import InputError
from .base import condition
from .machine import Machine
from .polygon import inside

Floats = NDArray[np.float64]

METHODS = ("gradient", "pattern", "evolution", "cma")
CMA_ROUND = 10_000  # evaluations from one start; the condition number has many local minima
SAMPLES = 100  # instants of a cycle in the objective
BETWEEN = 1e-4  # of each limit, for what lies between the instants of the final check
WORST = 8.0  # log10 of the largest condition number that the Gram matrix resolves
MARGIN = 0.002  # of each limit, kept back for what lies between the instants


class Series(NamedTuple):
    """A Fourier series of every axis, zero at the start of a cycle."""

    period: float  # [s]
    cosine: Floats  # (n, harmonics)
    sine: Floats

    def sample(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Positions, rates and accelerations (times, n)."""
        return fourier_motion.series(self.cosine, self.sine, self.period, t)


class Excitation(NamedTuple):
    """A motion of all axes: ``start`` plus a series."""

    start: Floats  # (n,)
    motion: Series

    def sample(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Positions, rates and accelerations (times, n)."""
        q, v, a = self.motion.sample(t)
        return self.start + q, v, a


@dataclass(frozen=True)
class Search:
    """What one search found; the seed fixes its start and its random numbers."""

    method: str
    condition: float
    evaluations: int
    excitation: Excitation


class Objective:
    """log10 of the condition number of the base regressor over vectors (..., size) of unbounded variables."""

    def __init__(self, machine: Machine, kept: tuple[int, ...]) -> None:
        self.machine, self.kept = machine, list(kept)
        k, w = np.arange(1, machine.harmonics + 1), 2.0 * np.pi * machine.frequency
        # Coefficients of unit speed: all, or those whose motion starts at rest and without acceleration.
        self._cosines = self._sines = np.eye(k.size)
        if machine.at_rest:
            self._cosines = np.linalg.svd((k**2.0)[None])[2][1:]
            self._sines = np.linalg.svd(k[None].astype(float))[2][1:]
        self._units = np.concatenate(
            [1.0 / np.linalg.norm(rows * k * w, axis=1) for rows in (self._cosines, self._sines)]
        )
        self.terms = self._units.size
        self.size = machine.axes * (1 + self.terms)
        times = np.arange(SAMPLES) / (SAMPLES * machine.frequency)
        parts = [self._motion(np.eye(1, self.terms, i)).sample(times) for i in range(self.terms)]
        self.basis = [np.concatenate([p[i] for p in parts], axis=1) for i in range(3)]
        self.evaluations = 0
        self.depth = _depth(machine)

    def __call__(self, x: Floats) -> Floats:
        """Values (...) of the vectors (..., size)."""
        x = np.asarray(x, dtype=float)
        self.evaluations += int(np.prod(x.shape[:-1]))
        start, amplitude = self._split(x)
        shape = [np.einsum("tk,...nk->...tn", part, amplitude) for part in self.basis]
        scale = self._scale(start, shape)[..., None, :]
        q, v, a = start[..., None, :] + scale * shape[0], scale * shape[1], scale * shape[2]
        outside = self._outside(q)
        full = self.machine.full_regressor(q, v, a)[..., self.kept]
        value = np.log10(condition(full.reshape(*full.shape[:-3], -1, len(self.kept))))
        return np.asarray(np.where(outside > 0.0, WORST + outside, np.minimum(value, WORST)))

    def excitation(self, x: Floats) -> Excitation:
        """The motion of a vector (size,), scaled into the limits between the instants, too."""
        return self.moving(*self._split(x))

    def moving(self, start: Floats, amplitude: Floats) -> Excitation:
        """The motion of a start (n,) and amplitudes (n, terms), scaled likewise."""
        shape = [np.einsum("tk,nk->tn", part, amplitude) for part in self.basis]
        motion = self._motion(amplitude * self._scale(start, shape)[:, None])
        fine = motion.sample(np.linspace(0.0, motion.period, 4001))
        extra = self._scale(start, fine, kept_back=BETWEEN)
        return Excitation(
            start, self._motion(amplitude * self._scale(start, shape)[:, None] * extra[:, None])
        )

    def _split(self, x: Floats) -> tuple[Floats, Floats]:
        n, low, high = self.machine.axes, self.machine.lower, self.machine.upper
        start = low + (high - low) * scipy.special.expit(x[..., :n])
        rest = x[..., n:].reshape(*x.shape[:-1], n, self.terms)
        return start, rest * self.machine.speed[:, None]

    def _scale(self, start: Floats, shape: Any, kept_back: float = MARGIN) -> Floats:
        """Largest share (..., n), up to one, of each axis that keeps its limits."""
        q, v, a = shape
        m, room = self.machine, 1.0 - kept_back
        use = np.stack(
            [
                np.abs(v).max(axis=-2) / (room * m.speed),
                np.abs(a).max(axis=-2) / (room * m.acceleration),
                q.max(axis=-2) / np.maximum(m.upper - start, 1e-9) / room,
                -q.min(axis=-2) / np.maximum(start - m.lower, 1e-9) / room,
            ]
        )
        return np.asarray(1.0 / np.maximum(use.max(axis=0), 1.0))

    def _outside(self, q: Floats) -> Floats:
        """How far the worst instant (...) lies outside the polygon; zero inside."""
        if self.depth is None or self.machine.polygon is None:
            return np.zeros(q.shape[:-2])
        lacking = np.maximum(MARGIN * self.polygon_size - self.depth(q), 0.0)
        return np.asarray(lacking.max(axis=-1) / self.polygon_size)

    @property
    def polygon_size(self) -> float:
        """Largest width of the polygon [m or rad]; one where there is none."""
        polygon = self.machine.polygon
        return 1.0 if polygon is None else float(np.ptp(polygon, axis=0).max())

    def _motion(self, amplitude: Floats) -> Series:
        half = self._cosines.shape[0]
        scaled = amplitude * self._units
        cosine, sine = scaled[:, :half] @ self._cosines, scaled[:, half:] @ self._sines
        return Series(1.0 / self.machine.frequency, cosine, sine)


def search(machine: Machine, kept: tuple[int, ...], method: str, budget: int, seed: int) -> Search:
    """Smallest condition number within ``budget`` evaluations.

    Raises InputError for an unknown method, or one whose optional package is missing.
    """
    if method not in METHODS:
        raise InputError("method", f"unknown search {method!r}", f"one of {', '.join(METHODS)}")
    objective = Objective(machine, kept)
    if method == "gradient":
        from .gradient import search as by_gradient

        excitation = by_gradient(objective, budget, seed)
    else:
        first = _start(objective, seed, min(200, budget // 4))
        found = {"pattern": _pattern, "evolution": _evolution, "cma": _cma}[method]
        excitation = objective.excitation(found(objective, first, budget, seed))
    return Search(method, of(machine, kept, excitation), objective.evaluations, excitation)


def random(machine: Machine, kept: tuple[int, ...], seed: int) -> Excitation:
    """A motion inside the limits that no search has improved."""
    objective = Objective(machine, kept)
    return objective.excitation(_start(objective, seed))


def of(machine: Machine, kept: tuple[int, ...], excitation: Excitation) -> float:
    """Condition number of the base regressor over 1000 instants of a cycle."""
    times = np.arange(1000) / 1000.0 * excitation.motion.period
    full = machine.full_regressor(*excitation.sample(times))[..., list(kept)]
    return float(condition(full.reshape(-1, len(kept))))


def _depth(machine: Machine) -> Callable[[Floats], Floats] | None:
    """Depth inside the polygon, tabled once: bilinear between nodes a two-hundredth of the travel apart."""
    if machine.polygon is None:
        return None
    axes = tuple(np.linspace(lo, hi, 201) for lo, hi in zip(machine.lower, machine.upper))
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    return RegularGridInterpolator(
        axes, inside(nodes, machine.polygon), bounds_error=False, fill_value=-1.0
    )


def _start(objective: Objective, seed: int, count: int = 50) -> Floats:
    """The best of ``count`` random motions, in the middle of the joint space."""
    rng = np.random.default_rng(seed)
    trial = 0.3 * rng.normal(size=(count, objective.size))
    m = objective.machine
    middle = (m.start - m.lower) / (m.upper - m.lower)
    trial[:, : m.axes] += np.log(middle / (1.0 - middle))
    return np.asarray(trial[int(np.argmin(objective(trial)))])


class _Spent(Exception):
    """The budget of evaluations is used up."""


def _counted(objective: Objective, budget: int) -> tuple[Callable[[Floats], float], dict]:
    best: dict[str, Any] = {"value": np.inf, "x": None}

    def value(x: Floats) -> float:
        if objective.evaluations >= budget:
            raise _Spent
        found = float(objective(x))
        if found < best["value"]:
            best["value"], best["x"] = found, np.array(x, dtype=float)
        return found

    return value, best


def _pattern(objective: Objective, first: Floats, budget: int, seed: int) -> Floats:
    try:
        import noisyopt
    except ImportError:
        raise _missing("pattern", "noisyopt") from None
    value, best = _counted(objective, budget)
    with suppress(_Spent):
        noisyopt.minimizeCompass(
            value, first, deltainit=0.5, deltatol=1e-3, errorcontrol=False, paired=False
        )
    return np.asarray(best["x"])


def _evolution(objective: Objective, first: Floats, budget: int, seed: int) -> Floats:
    size = 60
    rng = np.random.default_rng(seed)
    evolve: Any = scipy.optimize.differential_evolution  # its stubs know no vectorised function
    found = evolve(
        lambda x: objective(x.T),
        [(-3.0, 3.0)] * objective.size,
        init=np.clip(first + 0.5 * rng.normal(size=(size, objective.size)), -3.0, 3.0),
        maxiter=max(1, budget // size - 1),
        rng=rng,
        polish=False,
        vectorized=True,
        updating="deferred",
        tol=0.0,
    )
    return np.asarray(found.x)


def _cma(objective: Objective, first: Floats, budget: int, seed: int) -> Floats:
    import cma

    rounds = max(1, budget // CMA_ROUND)
    results = []
    for k in range(rounds):
        x0 = first if k == 0 else _start(objective, seed + 10_000 * k)
        options = {
            "seed": seed + 1 + k, "verbose": -9, "popsize": 20, "maxfevals": budget // rounds,
        }  # fmt: skip
        strategy = cma.CMAEvolutionStrategy(x0, 0.15, options)
        while not strategy.stop():
            x = strategy.ask()
            strategy.tell(x, objective(np.asarray(x)).tolist())
        results.append(strategy.result)
    return np.asarray(min(results, key=lambda result: result.fbest).xbest)


def _missing(method: str, package: str) -> InputError:
    return InputError(
        f"search {method!r}",
        f"package {package!r} is not installed",
        "the optional dependencies of identification",
        "Install gapscope[identification], or choose gradient, evolution or cma.",
    )
