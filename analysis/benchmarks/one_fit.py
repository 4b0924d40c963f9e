"""Group ``one-fit``: one structure fitted to one log by gapscope, through a Drake diagram and by ``mujoco.sysid``.

The nominal C-drive with dry friction at motors and collar is fitted to ``SAMPLES`` samples of a run of the open set
``coulomb`` by its one-sample-ahead prediction errors: own parameters within their tolerance, three levels and the
width of the sign. All start from the same point and minimise the same sum of squares.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from . import fit_peers
from .fit_peers import Numbers
from .rounds import Contender, Group, Skipped, measure, rows

NAME = "one-fit"
SET, MOTION, EFFECT = "coulomb", "helical", "friction.coulomb"
SAMPLES, STEPS = 1500, 20
OURS, DRAKE, MUJOCO = "gapscope", "scipy.optimize on a Drake diagram", "mujoco.sysid"
# Relative, of the fitted levels of dry friction: the searches end at 1e-8 of their own criteria.
TOLERANCE = 1e-2

Floats = NDArray[np.float64]


def one_fit(folder: Path | None, rounds: int, samples: int = SAMPLES) -> Group:
    """Time the fit of every contender over ``rounds`` interleaved rounds; skipped without the open set."""
    path = folder / SET if folder else None
    if path is None or not (path / "logset.yaml").is_file():
        reason = f"no log set {SET} in {folder}; give --open DIR or set GAPSCOPE_DATA"
        return _group((), rounds, (Skipped(name="log set", reason=reason),))
    task = _task(path, samples)
    fits = {OURS: _ours(task), DRAKE: _scipy(task, fit_peers.by_drake(task.log))}
    skipped = []
    try:
        fits[MUJOCO] = _sysid(task, fit_peers.by_mujoco(task.log))
        fits[MUJOCO](1)
    except ImportError as error:
        fits.pop(MUJOCO, None)
        skipped.append(Skipped(name=MUJOCO, reason=f"{error}; pip install 'gapscope[bench]'"))
    found: dict[str, _Fitted] = {}

    def run(name: str) -> Callable[[], None]:
        def once() -> None:
            found[name] = fits[name](STEPS)

        return once

    contenders = [Contender(name=name, run=run(name)) for name in fits]
    seconds, repeats = measure(contenders, rounds)
    medians = np.median(seconds, axis=0)
    rate = {n: found[n].simulations / t for n, t in zip(fits, medians)}
    checks = [_check(task, found[name], found[OURS], rate[name], rate[DRAKE]) for name in fits]
    return _group(rows(contenders, seconds, repeats, checks, DRAKE), rounds, tuple(skipped))


def _group(found: Any, rounds: int, skipped: tuple[Skipped, ...]) -> Group:
    return Group(
        name=NAME,
        task=f"fit the nominal C-drive with dry friction to {SAMPLES} samples of one run",
        rounds=rounds,
        reference=DRAKE if found else None,
        agreement=f"levels of dry friction within {TOLERANCE:g} of the largest, to {OURS}",
        rows=found,
        skipped=skipped,
    )


@dataclass(frozen=True)
class _Task:
    problem: Any  # of gap.prediction
    log: fit_peers.Log
    start: Floats  # parameters in units of their scales
    numbers: Callable[[Floats], Numbers]
    levels: NDArray[np.intp]  # which parameters are levels


@dataclass(frozen=True)
class _Fitted:
    x: Floats
    simulations: int


def _task(path: Path, samples: int) -> _Task:
    from ...models import drive
    from ..gap.hypothesis import Hypothesis
    from ..gap.logset import load_logset
    from ..gap.machines import read_machine
    from ..gap.prediction import Predictor, Problem

    machine, runs = read_machine(load_logset(path))
    run = _shortened(next(run for run in runs if run.settings.get("motion") == MOTION), samples)
    form = next(f for f in machine.forms([run]) if f.effect == EFFECT)
    problem = Problem(Predictor(machine, [run]), Hypothesis(forms=(form,)))
    start = np.array([p.starts[0] for p in problem.parameters]) / problem.scale

    def numbers(x: Floats) -> Numbers:
        values = dict(zip(problem.keys, problem.scale * x))
        plant = problem.hypothesis.plant(machine, values).drive
        columns = plant.element[:, [drive.VISCOUS, drive.FORWARD, drive.WIDTH]].T.tolist()
        return Numbers(plant.inertia_inverse.tolist(), *columns)

    bandwidth = getattr(machine, "bandwidth")  # noqa: B009, of a drive
    log = fit_peers.log_of(run.position, run.command, run.dt, bandwidth)
    named = [i for i, (_, name) in enumerate(problem.keys) if name.startswith("level_")]
    return _Task(problem, log, problem.inside(start), numbers, np.array(named))


def _shortened(run: Any, samples: int) -> Any:
    signals = ("t", "reference", "reference_rate", "reference_acceleration", "position", "command")
    short = {name: np.ascontiguousarray(getattr(run, name)[:samples]) for name in signals}
    return replace(run, **short, period=None)


def _search(task: _Task, residual: Any, jacobian: Any, steps: int) -> Floats:
    bounds = (task.problem.lower, task.problem.upper)
    tolerances: Any = {"ftol": 1e-8, "xtol": 1e-8, "gtol": 1e-10}
    found = least_squares(
        residual, task.start, jac=jacobian, bounds=bounds, max_nfev=steps, **tolerances
    )
    return np.asarray(found.x)


def _ours(task: _Task) -> Callable[[int], _Fitted]:
    """The predictor of a diagnosis, whose Jacobian's columns go to threads."""

    def fit(steps: int) -> _Fitted:
        predictor = task.problem.predictor
        before = predictor.simulations
        x = _search(task, task.problem.flat, task.problem.jacobian, steps)
        return _Fitted(x, predictor.simulations - before)

    return fit


def _counted(task: _Task, residual: fit_peers.Residual) -> tuple[Callable[[Floats], Floats], list]:
    calls: list[None] = []

    def flat(x: Floats) -> Floats:
        calls.append(None)
        return residual(task.numbers(x)).ravel()

    return flat, calls


def _scipy(task: _Task, residual: fit_peers.Residual) -> Callable[[int], _Fitted]:
    def fit(steps: int) -> _Fitted:
        flat, calls = _counted(task, residual)
        return _Fitted(_search(task, flat, "2-point", steps), len(calls))

    return fit


def _sysid(task: _Task, residual: fit_peers.Residual) -> Callable[[int], _Fitted]:
    def fit(steps: int) -> _Fitted:
        flat, calls = _counted(task, residual)
        lower, upper = task.problem.lower, task.problem.upper
        x = fit_peers.sysid_fit(flat, task.start, lower, upper, steps)
        return _Fitted(x, len(calls))

    return fit


def _check(
    task: _Task, fitted: _Fitted, ours: _Fitted, rate: float, drake: float
) -> tuple[str, bool]:
    levels = (task.problem.scale * ours.x)[task.levels]
    off = (task.problem.scale * (fitted.x - ours.x))[task.levels]
    differs = float(np.max(np.abs(off)) / np.max(np.abs(levels)))
    words = f"levels differ by {differs:.1e}; {fitted.simulations} simulations, {rate:.0f}/s"
    return f"{words}, {rate / drake:.3g} x Drake's", differs <= TOLERANCE
