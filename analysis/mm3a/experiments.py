"""Simulated calibration experiments of chapters 4-6: who drives where, and what is counted."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...models.mm3a import actuators, step_size
from ...models.mm3a.arm import Arm, gravity_in_base
from ...models.mm3a.limit_switch import heard_steps
from ...models.mm3a.step_size import StepModel
from ..errors import InputError
from .runs import LOOP, NO_FORCE, Run, mean_of_inverse

# Sizes [rad or m] of the steps at the nodes of a run.
StepTruth = Callable[[Run], NDArray[np.float64]]
UNCOUNTED = LOOP + 1
HALF = -0.5 * np.pi


@dataclass(frozen=True, kw_only=True)
class Environment:
    """Scatter of the experiments. The thesis prints p-values but no variances: these are chosen."""

    day: float = 0.02  # relative deviation of a day's factor, per joint and direction [-]
    run: float = 0.003  # relative deviation from run to run within a day [-]

    def __post_init__(self) -> None:
        if not (self.day >= 0.0 and self.run >= 0.0):
            raise ValueError(f"environment: {self}; expected deviations >= 0")


def prismatic_plan() -> list[Run]:
    """Six runs of Fig. 6.1: over the full travel, both ways, at three postures."""
    postures = ((HALF, 0.0), (0.0, HALF), (0.0, 0.0))  # q2, theta
    return [
        _run(3, direction, (0.0, q2, None), theta)
        for q2, theta in postures
        for direction in (1, -1)
    ]


def rotary_plan(joint: int = 2) -> list[Run]:
    """Eight runs of Fig. 6.3 in their order; joint 1 as by the role swap of section 6.2."""
    order = ((0.0, 0.0), (0.012, 0.0), (0.012, HALF), (0.0, HALF))  # q3, theta
    return [
        _run(joint, direction, (None, HALF, q3) if joint == 1 else (0.0, None, q3), theta)
        for q3, theta in order
        for direction in (-1, 1)
    ]


def calibration_plan() -> list[Run]:
    """The 14 runs of chapter 6 for joints 3 and 2, and the same 8 for joint 1."""
    return prismatic_plan() + rotary_plan(2) + rotary_plan(1)


def rotation_plan() -> list[Run]:
    """Section 4.4: joint 3 level, base turned about its axis in steps of pi/6."""
    return [
        _run(3, direction, (0.0, HALF, None), theta)
        for theta in -np.arange(4) * np.pi / 6
        for direction in (1, -1)
    ]


def interval_plan(q3: float, theta: float = 0.0) -> list[Run]:
    """Sections 5.3 and 6.2: joint 2 between stoppers pi/6 apart, from 0 to -pi."""
    edges = -np.arange(7) * np.pi / 6
    return [
        replace(_run(2, direction, (0.0, None, q3), theta), q2=start, target=target)
        for first, second in pairwise(edges)
        for direction, start, target in ((-1, first, second), (1, second, first))
    ]


def posture_plan(theta: float = 0.0) -> list[Run]:
    """Section 4.7: joint 3 at elbow angles from 0 to -pi in steps of pi/6."""
    return [
        _run(3, direction, (0.0, q2, None), theta)
        for q2 in -np.arange(7) * np.pi / 6
        for direction in (1, -1)
    ]


def empirical_truth(model: StepModel, arm: Arm) -> StepTruth:
    """Step sizes by the empirical model."""
    table, travel = model.table(), arm.upper_3 - arm.lower_3

    def sizes(run: Run) -> NDArray[np.float64]:
        side = step_size.POSITIVE if run.direction > 0 else step_size.NEGATIVE
        return np.array(
            [
                step_size.step_size(run.joint - 1, side, q, load, table, travel)
                for q, load in zip(run.postures(), run.loads(arm))
            ]
        )

    return sizes


def physical_truth(
    arm: Arm, parts: tuple[actuators.JointActuator, ...] | None = None, postures: int = 7
) -> StepTruth:
    """Step sizes by the physical actuators, interpolated between ``postures`` along each run."""
    parts = parts or actuators.joint_actuators()

    def sizes(run: Run) -> NDArray[np.float64]:
        gravity = gravity_in_base(run.theta, run.psi)
        nodes = run.postures()
        along = nodes[:, run.joint - 1]
        knots = np.linspace(run.start, run.target, postures)
        values = []
        for knot in knots:
            q = nodes[0].copy()
            q[run.joint - 1] = knot
            step = actuators.physical_step(
                run.joint - 1, run.direction, q, gravity, NO_FORCE, arm, parts
            )
            values.append(abs(step))
        fit = np.polynomial.Polynomial.fit(knots, values, postures - 1)
        return fit(along)

    return sizes


TRUTHS: dict[str, Callable[[Arm], StepTruth]] = {
    "empirical": lambda arm: empirical_truth(StepModel(), arm),
    "physical": lambda arm: physical_truth(arm),
}


def truth_named(name: str, arm: Arm | None = None) -> StepTruth:
    """Truth ``empirical`` or ``physical`` with its defaults; InputError for another name."""
    if name not in TRUTHS:
        raise InputError("truth", f"unknown truth {name!r}", f"one of {', '.join(TRUTHS)}")
    return TRUTHS[name](arm or Arm())


def full_experiment(truth: str, *, days: int, repeats: int, seed: int) -> list[Run]:
    """Calibration runs of all joints, rotation about the axis, and postures and intervals between."""
    plan = [
        *calibration_plan(),
        *rotation_plan()[2:],
        *posture_plan(),
        *interval_plan(0.0),
        *interval_plan(0.012),
    ]
    return perform(plan, truth_named(truth), days=days, repeats=repeats, seed=seed)


def perform(
    plan: Sequence[Run],
    truth: StepTruth,
    *,
    days: int = 1,
    repeats: int = 3,
    environment: Environment | None = None,
    seed: int = 0,
) -> list[Run]:
    """Count the steps of every run of ``plan``, ``repeats`` times on each of ``days`` days.

    Each (day, joint, direction) has its own factor and each run its own scatter, both Gaussian; the audio
    switch rounds the count up to its recording. Raises ValueError if ``days`` or ``repeats`` < 1.
    """
    if days < 1 or repeats < 1:
        raise ValueError(f"{days} days, {repeats} repeats; expected at least one of each")
    environment = environment or Environment()
    rng = np.random.default_rng(seed)
    exact = [run.distance / mean_of_inverse(truth(run)) for run in plan]
    performed = []
    for day in range(1, days + 1):
        factor = day_factors(environment, rng)
        for _ in range(repeats):
            for run, count in zip(plan, exact):
                scale = factor[run.joint - 1, (run.direction + 1) // 2]
                scale *= 1.0 + environment.run * rng.standard_normal()
                steps = heard_steps(int(np.ceil(count / scale)))
                performed.append(replace(run, day=f"day-{day}", steps=steps))
    return performed


def day_factors(environment: Environment, rng: np.random.Generator) -> NDArray[np.float64]:
    """Factors of one day by joint and direction, (3, 2)."""
    return 1.0 + environment.day * rng.standard_normal((3, 2))


def _run(
    joint: int, direction: int, q: tuple[float | None, float | None, float | None], theta: float
) -> Run:
    arm = Arm()
    lower, upper = arm.lower[joint - 1], arm.upper[joint - 1]
    start, target = (lower, upper) if direction > 0 else (upper, lower)
    q1, q2, q3 = (start if value is None else value for value in q)
    return Run(
        day="plan",
        joint=joint,
        direction=direction,
        q1=q1,
        q2=q2,
        q3=q3,
        target=target,
        theta=theta,
        psi=0.0,
        steps=UNCOUNTED,
    )
