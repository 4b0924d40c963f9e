"""Group ``growth``: how the cost of what a diagnosis repeats grows with its sizes.

Each row is one size of one axis; beside the largest stands the exponent p of time ~ size^p, fitted to the medians.
Log length and joints: one prediction of a log, what every fit repeats. Parameter sets: closed loops in lanes. Runs:
predictions of several runs. Hypotheses: fits of one structure, repeated. Processes and Dask workers: eight cases shared
among them, where -1 is the best there is.
"""

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import dataclass
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray

from ...diagrams.c_drive_loop import actuated_drive
from ...models import chain_kernels, drive, drive_batch, drive_kernels
from ...models.c_drive_controllers import loop_controller
from . import closed_loop, growth_of_fits
from .rounds import Contender, Group, Row, measure, rows

NAME = "growth"
MOST = 1.2  # exponent of log length: linear, and a fifth for caches and a busy machine
DT, BANDWIDTH = 1e-3, 60.0

Run = Callable[[], object]


@dataclass(frozen=True)
class Axis:
    """One size to vary; ``linear`` says that nothing worse will do."""

    name: str
    sizes: tuple[int, ...]
    make: Callable[[int], Run]
    linear: bool


def growth(rounds: int, axes: tuple[Axis, ...] | None = None) -> Group:
    """Time all sizes of all axes over ``rounds`` interleaved rounds."""
    with ExitStack() as open_:
        return _growth(rounds, usual_axes(open_) if axes is None else axes)


def _growth(rounds: int, axes: tuple[Axis, ...]) -> Group:
    contenders = [
        Contender(name=f"{axis.name}: {size}", run=axis.make(size))
        for axis in axes
        for size in axis.sizes
    ]
    for contender in contenders:
        contender.run()  # compiled before it is timed
    seconds, repeats = measure(contenders, rounds)
    medians = np.median(seconds, axis=0)
    checks, first = [], 0
    for axis in axes:
        last = first + len(axis.sizes)
        checks += _checks(axis, medians[first:last])
        first = last
    found: tuple[Row, ...] = rows(contenders, seconds, repeats, checks, None)
    return Group(
        name=NAME,
        task="predictions of logs (length, joints, runs), closed loops in lanes (parameter sets), fits "
        "(hypotheses), shared cases (processes, Dask workers)",
        rounds=rounds,
        reference=None,
        agreement=f"exponent of log length, parameter sets, runs and hypotheses at most {MOST:g}",
        rows=found,
    )


def exponent(sizes: tuple[int, ...], seconds: NDArray[np.float64]) -> float:
    """Slope of log time by log size, least squares."""
    return float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])


def _checks(axis: Axis, seconds: NDArray[np.float64]) -> list[tuple[str, bool]]:
    found = exponent(axis.sizes, seconds)
    fine = found <= MOST or not axis.linear
    return [("", True)] * (len(axis.sizes) - 1) + [(f"exponent {found:.2f}", fine)]


def usual_axes(open_: ExitStack) -> tuple[Axis, ...]:
    """Log length in samples of two joints, sets of 200 samples, joints and runs of 1000 samples.

    Dask workers only where ``distributed`` is installed; they are closed with ``open_``.
    """
    dask = growth_of_fits.of_dask_workers(open_)
    shared = (Axis("Dask workers", (1, 2), dask, linear=False),)
    return (
        Axis("log length", (2_000, 8_000, 32_000, 128_000), _length, linear=True),
        Axis("parameter sets", (256, 1_024, 4_096), _sets, linear=True),
        Axis("joints", (1, 2, 4, 8), _joints, linear=False),
        Axis("runs", (1, 2, 4, 8), growth_of_fits.of_runs, linear=True),
        Axis("hypotheses", (1, 2, 4), growth_of_fits.of_hypotheses, linear=True),
        Axis("processes", (1, 2), growth_of_fits.of_processes, linear=False),
        *(shared if find_spec("distributed") else ()),
    )


def _motion(samples: int, joints: int) -> NDArray[np.float64]:
    t = DT * np.arange(samples)[:, None]
    return np.asarray(np.sin(12.0 * t + np.arange(joints)))


def _length(samples: int) -> Run:
    plant = actuated_drive(closed_loop.task())
    position = _motion(samples, 2)
    command, residual = 0.5 * position, np.empty_like(position)
    return lambda: drive_kernels.predict(position, command, plant, DT, 1, BANDWIDTH, residual)


def _sets(sets: int) -> Run:
    config = closed_loop.task()
    plants = drive_batch.repeated(actuated_drive(config), sets)
    controller = loop_controller(config.controller.settings(), config.believed(), DT)
    reference, _, acceleration = config.program().sample(DT * np.arange(200))
    return lambda: drive_batch.simulate(
        reference, acceleration, plants, controller, DT, 1, 0.0, np.zeros(2)
    )


def _joints(n: int) -> Run:
    """A closed chain's prediction, whose terms are full matrices."""
    samples, parts = 1000, 1
    position = _motion(samples, n)
    command, residual = 0.5 * position, np.empty_like(position)
    tables = chain_kernels.Tables(
        0.01 * np.tile(np.eye(n), (samples, parts, 1, 1)),
        1e-5 * np.ones((samples, parts, n, n, n)),
        np.zeros((samples, parts, n)),
    )
    inertia = np.eye(n)
    plant = drive.ideal_drive(inertia, np.eye(n), 0.1 * np.ones(n), 0.5)
    weights = np.ones(parts)
    return lambda: chain_kernels.predict(
        position, command, tables, weights, inertia, plant, DT, 1, BANDWIDTH, residual
    )
