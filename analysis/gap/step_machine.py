r"""Stick-slip machines: a sample is a move, so many commanded steps of one joint and how far it went.

1. predicted move   :math:`\hat y = s\,\bar\gamma\,(1 + e)(n + r\,\mathbb 1_{rev}(1 - e^{-n/m}))`
2. mean step        :math:`\bar\gamma = 1 / \langle 1/\gamma \rangle` along the measured move
3. residual         :math:`(y - \hat y) / (n \bar\gamma_0)`, with :math:`\bar\gamma_0` of the stated model

s is the direction, n the number of steps, :math:`\gamma` the step law of ``models/mm3a/step_size.py``,
e what effects add (direction, day, warming), r the steps gained where a move reverses the one before (it may depend on the load)
and m how many steps that takes. Residuals are relative, so that joints that turn and joints that
slide weigh alike: there is one column, the move, whatever joint a run moves. Moves are
predicted one by one from their measured start: errors do not add up along a run.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from ...models.mm3a import step_size
from ...models.mm3a.arm import Arm
from .law_error import LawError
from .machine import Array, Machine, RunData, rms
from .move_location import locate_moves
from .slip_terms import PRISMATIC, SlipTerms, reversal_gain, step_change

if TYPE_CHECKING:
    from .effects import Effect, Form

NODES, WEIGHTS = np.polynomial.legendre.leggauss(5)  # along a move
SAME_ANGLE, SAME_LENGTH = 0.05, 0.5e-3  # starts this close are the same posture [rad], [m]
SAME_SHARE = 0.05  # of the travel of joint 3
ENOUGH_REPEATS = 30  # that show whether some moves fail
FEWEST_REPEATS = 5  # differences of repeated moves that make a floor
# What the law of ``step_size.py``, fitted without noise to the physical actuator of ``models/stick_slip.py``,
# misses of a move: 0.2 to 0.4 % (``analysis/mm3a/blind.py``, which has the table of what follows).
LAW_MISFIT = 0.004
# What the form of one physical effect leaves over what it removes, without scatter, at tuning seeds 20 to 28, where
# the law's own misfit is small beside the effect: payload 0.01 to 0.04, recoil 0.03, direction 0.03 to 0.06,
# direction memory 0.08. A quarter more for sizes that were not drawn.
FORM_MISFIT = 0.1
STATED = "repeatability of a move, stated or of all runs together"
REPEATED = "repeatability of repeated moves"
WITH_LAW = ", and {:.2g} % that the step law itself may be off"


@dataclass
class StepPlant:
    """Step law of the three joints with what effects have changed; arrays by joint, then side (-, +)."""

    table: Array  # (3, 2, 4) parameters of ``step_size.py``
    curve: Array  # (3, 2) step lost with the square of the load factor [rad or m]
    change: Array  # (3, 2) relative change of every step [-]
    day: Array  # (sessions, 3, 2) relative change in a session [-]
    warming: Array  # (3,) relative growth of steps from cold to warm [-]
    reversal: Array  # (3,) steps gained by a move that reverses the one before [-]
    reversal_load: Array  # (3,) the same by the load factor that opposes the move [-]
    payload: float = 0.0  # mass on the tip [kg]
    recoil_power: float = 1.0  # of |cos q2| in the recoil of joint 3 [-]
    warm_up: float = 600.0  # time to 63 % of the warming [s]
    memory: float = 0.0  # steps to 63 % of the reversal gain [-]
    reading: float = 1.0  # measured per true displacement [-]
    slip: SlipTerms = field(default_factory=SlipTerms)  # amounts that steps gain or lose
    time: float = 0.0  # how long the machine had been running when the run began [s]

    def finished(self) -> "StepPlant":
        """Return the plant; nothing is left to do."""
        return self


@dataclass(frozen=True, kw_only=True)
class MoveRun(RunData):
    """Moves of one joint; arrays are (moves,) or (moves, nodes) along each move."""

    joint: int  # index of the joint
    session: int  # index of the session
    side: NDArray[np.int64]  # 0 negative, 1 positive
    steps: Array  # commanded, unsigned
    moved: Array  # measured, signed [rad or m]
    elbow: Array  # (moves, nodes) q2 [rad]
    extension: Array  # (moves, nodes) q3 over the travel of joint 3 [-]
    load: Array  # (moves, nodes) load factor of the joint
    load_per_kg: Array  # (moves, nodes) what a mass on the tip adds to it [1/kg]
    pull: Array  # (moves, nodes) load, over that of the level, retracted arm in 1 g [-]
    pull_per_kg: Array  # (moves, nodes) what a mass on the tip adds to it [1/kg]
    inertia: Array  # (moves, nodes) of the joint, over that of the level, retracted arm [-]
    inertia_per_kg: Array  # (moves, nodes) what a mass on the tip adds to it [1/kg]
    reverses: NDArray[np.bool_]  # the move goes against the one before it
    start_position: Array  # (moves,) of the moving joint [rad or m]
    expected: Array  # (moves,) mean step of the stated law [rad or m]


@dataclass(frozen=True, kw_only=True)
class StepMachine(Machine):
    """Nominal step law of a stick-slip arm and how its moves are predicted."""

    table: Array  # (3, 2, 4) as stated, 0 for what does not move
    curve: Array  # (3, 2) as stated [rad or m]
    arm: Arm
    moving: tuple[int, ...]  # indices of the joints that move
    sessions: tuple[str, ...]
    repeatability: float  # of a move, relative, where runs repeat too few
    law_misfit: float = LAW_MISFIT  # relative rms that the law misses of a move without any effect

    def build(self, values: Mapping[str, float]) -> StepPlant:
        """The stated step law, its basic steps, load and recoil terms scaled by joint."""
        table, curve = self.table.copy(), self.curve.copy()
        for joint in self.moving:
            basic, load = _columns(joint)
            table[joint, :, basic] *= values[f"basic_{joint + 1}"]
            table[joint, :, load] *= values.get(f"load_{joint + 1}", 1.0)
            curve[joint] *= values.get(f"load_{joint + 1}", 1.0)
            if joint == PRISMATIC:
                table[joint, :, 1] *= values.get("recoil_3", 1.0)
        return StepPlant(
            table=table,
            curve=curve,
            change=np.zeros((3, 2)),
            day=np.zeros((len(self.sessions), 3, 2)),
            warming=np.zeros(3),
            reversal=np.zeros(3),
            reversal_load=np.zeros(3),
        )

    def predict(self, run: RunData, plant: StepPlant) -> Array:
        """Relative errors (3) of the moves in the run's window (moves, 1); NaN if a step has no length."""
        assert isinstance(run, MoveRun)
        residual = (run.moved - move(run, plant)) / (run.steps * run.expected)
        return np.asarray(residual[run.window, None])

    def forms(self, runs: Sequence[RunData]) -> "list[Form]":
        """Every effect of ``step_effects`` that these moves excite."""
        from .step_effects import forms_for

        return forms_for(self, [run for run in runs if isinstance(run, MoveRun)])

    def catalogue(self) -> "Mapping[str, Effect]":
        """Effects of ``step_effects``."""
        from .step_effects import catalogue

        return catalogue()

    @property
    def places(self) -> tuple[str, ...]:
        """The joints that move."""
        return tuple(f"joint_{joint + 1}" for joint in self.moving)

    @property
    def residual_unit(self) -> str:
        """Residuals are relative."""
        return "1"

    @property
    def metric(self) -> str:
        """What shrinks."""
        return "rms relative error of a move on held-out runs"

    def spread(self, runs: Sequence[RunData]) -> float:
        """Rms of a predicted relative displacement, which is 1 by (3)."""
        return 1.0

    def locate(
        self, runs: Sequence[RunData], residuals: Sequence[Array], seed: int
    ) -> dict[str, list[dict[str, Any]]]:
        """Shares by joint, direction against the load, pace of change and run."""
        return locate_moves(
            [run for run in runs if isinstance(run, MoveRun)], residuals, self.moving, seed
        )

    @property
    def law_error(self) -> LawError:
        """The step law is empirical."""
        return LawError(law=self.law_misfit, form=FORM_MISFIT)

    def floor(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> tuple[list[Array], str]:
        """Differences of repeated moves over sqrt(2), or what the log set states, and the law's misfit in quadrature."""
        found, source = self.repeatability_of(runs, residuals)
        misfit = self.law_misfit
        return [np.copysign(np.hypot(f, misfit), f) for f in found], source + WITH_LAW.format(
            100.0 * misfit
        )

    def repeatability_of(
        self, runs: Sequence[RunData], residuals: Sequence[Array]
    ) -> tuple[list[Array], str]:
        """Differences of repeated moves over sqrt(2); where there are too few, what the log set states."""
        found = [
            repeats(run, residual)
            for run, residual in zip(runs, residuals)
            if isinstance(run, MoveRun)
        ]
        if sum(len(f) for f in found) >= FEWEST_REPEATS:
            size, source = rms([f for f in found if len(f)]), REPEATED
        else:
            size, source = self.repeatability, STATED
        own = [f if source == REPEATED and len(f) else None for f in found]
        return [alternating(size, r) if f is None else f for f, r in zip(own, residuals)], source

    def out_of_step(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> float | None:
        """Rms of what does not repeat over its Gaussian core, at the lower end of its error.

        Well above 1 where single moves fail: the many that do not tell how well the rest repeat.
        """
        found = np.concatenate(
            [repeats(run, r) for run, r in zip(runs, residuals) if isinstance(run, MoveRun)]
        )
        core = float(stats.median_abs_deviation(found.ravel(), scale="normal")) if found.size else 0
        if found.size < ENOUGH_REPEATS or not core > 0.0:
            return None
        return rms([found]) / core / (1.0 + 2.0 / float(np.sqrt(found.size)))


def alternating(size: float, residual: Array) -> Array:
    """Noise of known size in the shape of a residual."""
    signs = 1.0 - 2.0 * (np.arange(len(residual)) % 2)
    return np.asarray(size * signs[:, None] * np.ones(residual.shape[1]))


def mean_step(run: MoveRun, plant: StepPlant) -> Array:
    """Mean step (2) of every move at the load and posture along it, (moves,) [rad or m]; NaN if none."""
    p, curve = plant.table[run.joint, run.side], plant.curve[run.joint, run.side]
    load = run.load + plant.payload * run.load_per_kg
    bend = curve[:, None] * load**2
    if run.joint == PRISMATIC:
        recoil = p[:, 1:2] * np.abs(np.cos(run.elbow)) ** (plant.recoil_power - 1.0)
        sizes = step_size.prismatic_step(run.elbow, load, p[:, :1] - bend, recoil, p[:, 2:3])
    else:
        basic = (p[:, :1] - bend, p[:, 1:2] - bend)
        sizes = step_size.rotary_step(run.extension, load, *basic, p[:, 2:3], p[:, 3:4], 1.0)
    sizes = sizes + step_change(run, plant.slip, plant.warm_up)
    usable = np.all(sizes > 0.0, axis=1)
    safe = np.where(usable[:, None], sizes, 1.0)
    return np.where(usable, 2.0 / np.sum(WEIGHTS / safe, axis=1), np.nan)


def move(run: MoveRun, plant: StepPlant) -> Array:
    """Predicted reading (1) of every move, signed (moves,) [rad or m]."""
    j = run.joint
    change = plant.change[j, run.side] + plant.day[run.session, j, run.side]
    change = change + plant.warming[j] * (1.0 - np.exp(-run.t / plant.warm_up))
    sign = 2.0 * run.side - 1.0
    opposing = sign * run.load.mean(axis=1)
    gained = (plant.reversal[j] + plant.reversal_load[j] * opposing) * run.reverses
    if plant.memory > 0.0:
        gained = gained * (1.0 - np.exp(-run.steps / plant.memory))
    steps = mean_step(run, plant) * (1.0 + change) * (run.steps + gained)
    return np.asarray(plant.reading * sign * (steps + reversal_gain(run, plant.slip)))


def repeats(run: MoveRun, residual: Array) -> Array:
    """What repeats of a move do not repeat: differences over sqrt(2) of like moves, one after the other.

    Alike are moves of equal steps, direction and history that start at the same place.
    """
    width = SAME_LENGTH if run.joint == PRISMATIC else SAME_ANGLE
    window = np.arange(len(run.t))[run.window]
    found: list[Array] = []
    last: dict[tuple[Any, ...], list[int]] = {}
    for row, i in enumerate(window):
        alike = (run.side[i], run.steps[i], run.reverses[i])
        before = last.setdefault(alike, [])
        near = [k for k in before if _same_start(run, int(window[k]), int(i), width)]
        if near:
            found.append((residual[row] - residual[near[-1]]) / np.sqrt(2.0))
            before.remove(near[-1])
        before.append(row)
    return np.array(found).reshape(-1, residual.shape[1])


def _same_start(run: MoveRun, a: int, b: int, width: float) -> bool:
    return bool(
        abs(run.start_position[a] - run.start_position[b]) < width
        and abs(run.elbow[a, 0] - run.elbow[b, 0]) < SAME_ANGLE
        and abs(run.extension[a, 0] - run.extension[b, 0]) < SAME_SHARE
    )


def _columns(joint: int) -> tuple[list[int], list[int]]:
    """Columns of the table that are basic steps and load terms."""
    return ([0], [2]) if joint == PRISMATIC else ([0, 1], [2, 3])


def with_expectation(run: MoveRun, machine: StepMachine) -> MoveRun:
    """The run with the mean steps of the stated law, and its measured moves over them as positions."""
    expected = mean_step(run, machine.build(machine.nominal()))
    signed = (2.0 * run.side - 1.0) * run.steps * expected
    return replace(run, expected=expected, position=(run.moved / signed)[:, None])
