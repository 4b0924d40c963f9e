"""Group ``mechanisms``: robots as reduced model, projected plant and SAP plant, and displacement analyses.

Every model moves its robot from rest for ``SAMPLES`` steps of 1 ms under constant forces: the reduced model and the
projected plant by ODE4 with four evaluations a step, SAP by its own discrete step. The forces hold the robot against
gravity and push it by ``PUSH`` of its own inertia.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import mechanism_models
from .rounds import Contender, Group, Skipped, measure, rows

NAME = "mechanisms"
SAMPLES, DT = 100, 1e-3
# ODE4 with the same accelerations: what rounding grows to, by the condition of the closures.
EQUAL = 1e-8
# Position by SAP, n steps of semi-implicit Euler under a constant acceleration: 1/n too far.
FIRST_ORDER = 2.0
POSTURES = 10_000  # displacement analyses a run

Floats = NDArray[np.float64]


def mechanisms(rounds: int, samples: int = SAMPLES, postures: int = POSTURES) -> Group:
    """Time all models of all robots over ``rounds`` interleaved rounds."""
    robots = mechanism_models.robots()
    jobs = [job for robot in robots for job in _jobs(robot, samples, postures)]
    contenders = [Contender(name=job.name, run=job.run) for job in jobs]
    agree = [job.check() for job in jobs]
    seconds, repeats = measure(contenders, rounds)
    checks = [
        (f"{words}; {job.work / float(np.median(times)):.3g} {job.unit}", right)
        for job, (words, right), times in zip(jobs, agree, seconds.T)
    ]
    return Group(
        name=NAME,
        task=f"{samples} steps of 1 ms from rest under constant forces; {postures} displacement analyses",
        rounds=rounds,
        reference=None,
        agreement=f"joint positions to the reduced model: projected plant within {EQUAL:g} of the way, SAP, of first "
        f"order, within {FIRST_ORDER / samples:g}; forward undoes inverse within {EQUAL:g}",
        rows=rows(contenders, seconds, repeats, checks, None),
        skipped=tuple(
            Skipped(name=f"{robot.name} SAP plant", reason=robot.without_sap)
            for robot in robots
            if robot.discrete is None
        ),
    )


@dataclass(frozen=True)
class _Job:
    name: str
    run: Callable[[], Any]
    check: Callable[[], tuple[str, bool]]
    work: float  # what one run gets done, in ``unit`` seconds
    unit: str


def _jobs(robot: mechanism_models.Robot, samples: int, postures: int) -> list[_Job]:
    start, force = robot.start, robot.force()

    def reduced() -> Floats:
        return robot.reduced(start, force, samples, DT)

    def projected() -> Floats:
        return mechanism_models.ode4(robot.projected, start, force, samples, DT)

    discrete = robot.discrete and robot.discrete(start, force, samples, DT)
    there = robot.postures(postures)

    def against(run: Callable[[], Floats], tolerance: float) -> Callable[[], tuple[str, bool]]:
        def check() -> tuple[str, bool]:
            right = reduced()
            found = float(np.max(np.abs(run() - right)) / np.max(np.abs(right - start)))
            return f"differs by {found:.1e}", found <= tolerance

        return check

    def displaced() -> tuple[str, bool]:
        found = float(np.max(np.abs(robot.there_and_back(there) - there)))
        return f"back within {found:.1e}", found <= EQUAL

    models = [("reduced", reduced, EQUAL), ("projected plant", projected, EQUAL)]
    if discrete:
        models.append(("SAP plant", discrete, FIRST_ORDER / samples))
    jobs = [
        _Job(f"{robot.name} {name}", run, against(run, tolerance), samples * DT, "x real time")
        for name, run, tolerance in models
    ]
    analyses = f"{robot.name} displacement"
    back = lambda: robot.there_and_back(there)  # noqa: E731
    return [*jobs, _Job(analyses, back, displaced, 2.0 * postures, "analyses/s")]
