"""Axes of ``growth`` that a diagnosis grows along: runs, hypotheses, and the workers that cases are shared among."""

from collections.abc import Callable
from contextlib import ExitStack
from functools import cache
from typing import Any

import numpy as np

from ...diagrams.c_drive_loop import actuated_drive
from ...models import drive_kernels
from ...models.c_drive import CDriveParameters
from ...models.c_drive_controllers import PD, loop_controller
from ...models.motion import c_drive_motion
from . import closed_loop

Run = Callable[[], object]
DT, SAMPLES = 1e-3, 1000
TOLERANCE = 0.03  # of the nominal parameters
CASES, LOOPS = 8, 300  # shared among workers; closed loops of a case


def of_runs(count: int) -> Run:
    """Predictions of ``count`` runs with one hypothesis."""
    problem = _problem(count)
    x = np.array([p.starts[0] for p in problem.parameters]) / problem.scale
    return lambda: problem.runs([x])


def of_hypotheses(count: int) -> Run:
    """Fits of ``count`` hypotheses to two runs, which are one and the same: dry friction at motors and collar."""
    from ..gap.fitting import fit

    problem = _problem(2)
    retuned = fit(problem.predictor, type(problem.hypothesis)())

    def run() -> None:
        for _ in range(count):
            fit(problem.predictor, problem.hypothesis, retuned)

    return run


def of_processes(count: int) -> Run:
    """``CASES`` cases on ``count`` processes of this machine (1: this one)."""
    from .. import workers

    return lambda: list(workers.each(case, [(i,) for i in range(CASES)], workers=count))


def of_dask_workers(open_: ExitStack) -> Callable[[int], Run]:
    """``CASES`` cases on ``count`` workers of a Dask scheduler of this machine, closed with ``open_``."""
    from .. import workers

    def make(count: int) -> Run:
        from distributed import LocalCluster

        cluster = open_.enter_context(
            LocalCluster(
                n_workers=count,
                threads_per_worker=1,
                host="127.0.0.1",
                dashboard_address="127.0.0.1:0",
                silence_logs=50,
            )
        )
        address = str(cluster.scheduler_address)
        return lambda: list(workers.each(case, [(i,) for i in range(CASES)], cluster=address))

    return make


def case(number: int) -> float:
    """The C-drive's closed loop ``LOOPS`` times with friction of its own; last position [rad]."""
    config = closed_loop.task()
    plant, controller = actuated_drive(config), _controller()
    plant.element[:, 0] *= 1.0 + 0.01 * number
    reference, _, acceleration = config.program().sample(DT * np.arange(SAMPLES))
    position, command, delivered = (np.zeros((SAMPLES, 2)) for _ in range(3))
    for _ in range(LOOPS):
        position[0] = 0.0
        drive_kernels.simulate(
            reference, acceleration, plant, controller, DT, 1, 0.0,
            drive_kernels.initial_memory(controller, position[0]), position, command, delivered,
        )  # fmt: skip
    return float(position[-1, 0])


def _controller() -> Any:
    return loop_controller(PD(), CDriveParameters(), DT)


@cache
def _problem(runs: int) -> Any:
    """Dry friction fitted to ``runs`` closed loops of the C-drive that has some."""
    from ..gap.hypothesis import Hypothesis
    from ..gap.machine import RunData
    from ..gap.machines.c_drive import c_drive_machine
    from ..gap.prediction import Predictor, Problem

    machine = c_drive_machine(CDriveParameters(), TOLERANCE)
    program = c_drive_motion("helical", 2.0)
    t: Any = DT * np.arange(SAMPLES)
    reference, rate, acceleration = program.sample(t)
    position, command, delivered = (np.zeros((SAMPLES, 2)) for _ in range(3))
    controller = _controller()
    drive_kernels.simulate(
        reference, acceleration, actuated_drive(closed_loop.task()), controller, DT, 1, 0.0,
        drive_kernels.initial_memory(controller, position[0]), position, command, delivered,
    )  # fmt: skip
    run = RunData(
        name="run", use="fit", settings={}, dt=DT, t=t, reference=reference, reference_rate=rate,
        reference_acceleration=acceleration, position=position, command=command,
        controller=controller, period=None, lsb=0.0,
    )  # fmt: skip
    form = next(f for f in machine.forms([run]) if f.effect == "friction.coulomb")
    return Problem(Predictor(machine, [run] * runs), Hypothesis(forms=(form,)))
