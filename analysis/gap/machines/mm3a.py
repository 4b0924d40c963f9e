"""Nominal step model of an MM3A micromanipulator (``system.kind: mm3a``); samples are moves.

``system.nominal`` states the step law of ``models/mm3a/step_size.py`` of the joints that move, as
``calibration.json`` does, and by how much repeats of a move differ where the log repeats none::

    nominal:
      joint_3_positive: {basic: 9.72e-7, recoil: 0.27, load: 3.76e-7}       # m, 1, m
      joint_2_positive: {basic: 9.0e-5, load: -1.2e-5}                      # rad; or by extension:
      joint_2_negative: {basic_retracted: 9.8e-5, basic_extended: 9.1e-5}   # what is left out is 0
      joint_3_negative: {basic: 8.99e-7, load: -4.36e-7, curve: 5.0e-8}     # lost with the load squared
      arm: {mass_3: 0.002}                                                  # defaults of models/mm3a/arm.py
      repeatability: 0.003
      law_error: 0.004                                                      # default, 0 for an exact law

Columns ``t: s`` (since the session began), ``steps: 1`` (signed, commanded), ``q1: rad``, ``q2: rad``,
``q3: m`` (before the move), ``moved: rad or m`` (measured, of the joint that moves).

Keys of a run: ``joint`` (1, 2, 3); ``theta_rad``, ``psi_rad`` tilt of the base (0); ``session`` a label;
``force_N`` known force on the tip in frame 0; ``run_in_steps`` steps in the direction of the move that
were made before each of them and not logged, which makes a reversal invisible (0).

The floor counts in what the step law itself may be off (``law_error``, relative rms of a move), and a claim must be larger than that
and than what the form of one effect may miss (``law_error.py``); ``analysis/mm3a/blind.py`` has what this brings.
"""

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from ....models.mm3a import step_size
from ....models.mm3a.arm import Arm, gravity_in_base
from ...errors import InputError
from ..checks import shown
from ..description import FILE
from ..logset import LogSet, Run
from ..machine import Array, RunData, own_parameter, rms
from ..slip_terms import burden
from ..step_machine import (
    FEWEST_REPEATS,
    LAW_MISFIT,
    NODES,
    PRISMATIC,
    MoveRun,
    StepMachine,
    repeats,
    with_expectation,
)
from .settings import Settings, nominal_settings, require_units, run_settings, tolerance

SIDES = ("negative", "positive")
RUN_KEYS = ("joint", "theta_rad", "psi_rad", "session", "force_N", "run_in_steps")
COLUMNS = {"steps": "1", "q1": "rad", "q2": "rad", "q3": "m", "moved": "rad or m"}
KEYS = {
    PRISMATIC: {"basic": 0, "recoil": 1, "load": 2, "curve": 4},
    0: {
        "basic_retracted": 0,
        "basic_extended": 1,
        "load_retracted": 2,
        "load_extended": 3,
        "curve": 4,
    },
}
BOTH_ENDS = {
    "basic": ("basic_retracted", "basic_extended"),
    "load": ("load_retracted", "load_extended"),
}


def read(logset: LogSet) -> tuple[StepMachine, list[RunData]]:
    """Machine and runs of a log set of moves."""
    require_units(logset, COLUMNS)
    names = {f"joint_{j}_{side}" for j in (1, 2, 3) for side in SIDES}
    settings = nominal_settings(logset, names | {"arm", "repeatability", "law_error"})
    where = f"{logset.folder / FILE}, system.nominal"
    nominal = logset.system.get("nominal", {})
    stated = settings.number("repeatability", positive=True) if "repeatability" in nominal else None
    moving = tuple(sorted({_joint(logset, run) for run in logset.runs}))
    table = _table(where, nominal, _directions(logset))
    machine = StepMachine(
        kind="mm3a",
        joints=("move",),
        position_unit="1",
        effort_unit="1",
        own=(),
        table=table[:, :, :4],
        curve=table[:, :, 4],
        arm=_arm(where, nominal.get("arm", {})),
        moving=moving,
        sessions=tuple(dict.fromkeys(_session(run) for run in logset.runs)),
        repeatability=stated or np.nan,
        law_misfit=_law_error(where, settings),
    )
    machine = _with_own(machine, tolerance(logset))
    runs = _with_history([_run(logset, run, machine) for run in logset.runs])
    runs = [with_expectation(run, machine) for run in runs]
    if stated is None:
        machine = replace(machine, repeatability=_repeatability(logset, machine, runs))
    return machine, list(runs)


def _law_error(where: str, settings: Settings) -> float:
    stated = settings.number("law_error", LAW_MISFIT)
    if not 0.0 <= stated < 1.0:
        raise InputError(
            f"{where}.law_error",
            f"{stated:g}",
            "the relative rms by which the stated law misses a move: 0 or more, below 1",
        )
    return stated


def _repeatability(logset: LogSet, machine: StepMachine, runs: Sequence[MoveRun]) -> float:
    """Rms difference over sqrt(2) of all repeated moves, which hardly depends on the model."""
    plant = machine.build(machine.nominal())
    found = np.concatenate([repeats(run, machine.predict(run, plant)) for run in runs])
    if len(found) < FEWEST_REPEATS or not np.any(found):
        raise InputError(
            f"{logset.folder / FILE}",
            f"{len(found)} moves repeat another, and system.nominal.repeatability is not stated",
            f"{FEWEST_REPEATS} repeated moves at least, or the relative repeatability of a move",
            "Without it there is no noise floor, and no gap can be told from scatter.",
        )
    return rms([found])


def _with_own(machine: StepMachine, relative_tolerance: float) -> StepMachine:
    """The machine with one factor by joint of its basic steps, load and recoil terms."""
    own = []
    for joint in machine.moving:
        own.append(f"basic_{joint + 1}")
        if np.any(machine.table[joint, :, 2:]):
            own.append(f"load_{joint + 1}")
        if joint == PRISMATIC and np.any(machine.table[joint, :, 1]):
            own.append("recoil_3")
    return replace(
        machine, own=tuple(own_parameter(name, "1", 1.0, relative_tolerance) for name in own)
    )


def _table(where: str, nominal: Mapping[str, Any], directions: set[tuple[int, int]]) -> Array:
    """Parameters (3, 2, 4) of ``step_size.py`` and a curve; 0 for what does not move."""
    table = np.zeros((3, 2, 5))
    for joint, side in sorted(directions):
        name = f"joint_{joint + 1}_{SIDES[side]}"
        stated = nominal.get(name)
        if not isinstance(stated, dict):
            raise InputError(
                where,
                f"{name} is {stated!r}, but that joint moves in that direction",
                f"{name}: with its step, such as `basic: {9e-7 if joint == PRISMATIC else 9e-5}`",
            )
        table[joint, side] = _step(f"{where}.{name}", stated, joint)
    return table


def _step(where: str, stated: Mapping[str, Any], joint: int) -> Array:
    keys = KEYS[PRISMATIC if joint == PRISMATIC else 0]
    shorthand = {} if joint == PRISMATIC else BOTH_ENDS
    settings = Settings(where, stated, {*keys, *shorthand})
    row = np.zeros(5)
    for name in stated:
        for key in shorthand.get(name, (name,)):
            row[keys[key]] = settings.number(name)
    basic = row[[column for key, column in keys.items() if key.startswith("basic")]]
    if not np.all(basic > 0.0):
        raise InputError(where, f"basic steps are {basic.tolist()}", "positive numbers in rad or m")
    return row


def _arm(where: str, stated: Any) -> Arm:
    if not isinstance(stated, dict):
        raise InputError(f"{where}.arm", f"{stated!r}", "a mapping of arm constants")
    settings = Settings(f"{where}.arm", stated, {field.name for field in fields(Arm)})
    try:
        return Arm(**{name: settings.number(name) for name in stated})
    except InputError:
        raise
    except ValueError as error:
        found, _, expected = str(error).partition("; expected ")
        raise InputError(f"{where}.arm", found, expected or "constants of a possible arm") from None


def _run(logset: LogSet, run: Run, machine: StepMachine) -> MoveRun:
    joint = _joint(logset, run)
    settings = run_settings(logset, run, *RUN_KEYS)
    settings.text("session", "1")
    steps = run.columns["steps"]
    _check_steps(logset, run)
    sign = np.sign(steps)
    q = run.stack("q1", "q2", "q3")
    along = np.repeat(q[:, :, None], NODES.size, axis=2)  # (moves, 3, nodes)
    along[:, joint] += 0.5 * (NODES + 1.0) * run.columns["moved"][:, None]
    gravity = np.array(
        gravity_in_base(settings.number("theta_rad", 0.0), settings.number("psi_rad", 0.0))
    )
    force = settings.numbers("force_N", 3, (0.0, 0.0, 0.0))
    posture = (along[:, 0], along[:, 1], along[:, 2])
    load = step_size.load_factors(posture, gravity, force, machine.arm)[joint]
    heavier = step_size.load_factors(posture, gravity, force + gravity, machine.arm)[joint]
    run_in = settings.number("run_in_steps", 0.0, least=0.0)
    reverses = np.concatenate([[False], sign[1:] != sign[:-1]]) & (run_in == 0.0)
    ones = np.ones((len(steps), 1))
    return MoveRun(
        name=run.name, use=run.use, settings=run.settings,
        dt=float(np.median(np.diff(run.columns["t"]))), t=run.columns["t"],
        reference=ones, reference_rate=sign[:, None], reference_acceleration=np.zeros_like(ones),
        position=ones, command=ones, controller=None, period=None, lsb=0.0,
        joint=joint, session=machine.sessions.index(_session(run)),
        side=(sign > 0.0).astype(np.int64), steps=np.abs(steps), moved=run.columns["moved"],
        elbow=along[:, 1],
        extension=(along[:, 2] - machine.arm.lower_3) / (machine.arm.upper_3 - machine.arm.lower_3),
        load=load + np.zeros_like(along[:, 1]), load_per_kg=heavier - load + np.zeros_like(along[:, 1]),
        reverses=reverses, start_position=q[:, joint], expected=np.ones(len(steps)),
        start=settings.start,
        **burden(posture, gravity, force, joint, machine.arm),
    )  # fmt: skip


def _joint(logset: LogSet, run: Run) -> int:
    joint = run.settings.get("joint")
    if isinstance(joint, bool) or joint not in (1, 2, 3):
        raise InputError(
            f"{logset.folder / FILE}, runs[{run.name}].joint", shown(joint), "1, 2 or 3"
        )
    return int(joint) - 1


def _session(run: Run) -> str:
    return str(run.settings.get("session", "1"))


def _directions(logset: LogSet) -> set[tuple[int, int]]:
    return {
        (_joint(logset, run), int(step > 0.0))
        for run in logset.runs
        for step in run.columns["steps"]
    }


def _with_history(runs: Sequence[MoveRun]) -> list[MoveRun]:
    """The runs, with the first move of one marked that reverses the last one of its joint in the session."""
    found = []
    for run in runs:
        before = [
            r for r in runs
            if (r.joint, r.session) == (run.joint, run.session) and r.t[-1] < run.t[0]
        ]  # fmt: skip
        reverses = run.reverses.copy()
        if before and not run.settings.get("run_in_steps", 0.0):
            reverses[0] = max(before, key=lambda r: r.t[-1]).side[-1] != run.side[0]
        found.append(replace(run, reverses=reverses))
    return found


def _check_steps(logset: LogSet, run: Run) -> None:
    """Refuse moves without steps, parts of steps, and moves that go nowhere or backward."""
    steps, moved = run.columns["steps"], run.columns["moved"]
    checks = (
        (
            "steps",
            steps,
            (steps == 0.0) | (steps != np.round(steps)),
            "a whole number of steps, not 0",
        ),
        ("moved", moved, moved * steps <= 0.0, "a displacement in the direction of the steps"),
    )
    for name, values, bad, expected in checks:
        if np.any(bad):
            row = int(np.argmax(bad))
            raise InputError(
                f"{logset.folder / run.name}, row {row + 2}, column {name}",
                f"{values[row]:g}",
                expected,
                "" if name == "steps" else "A move against an end stop says nothing: leave it out.",
            )
