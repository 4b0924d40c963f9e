"""Machines that are rigid bodies: predicted by their acceleration equation at the measured state.

With measured positions q, and their zero-phase smoothed values and rates in all nonlinear terms,

    e = dt^2 / (1 - p z^-1)^2 [ (q_{k+1} - 2 q_k + q_{k-1}) / dt^2 - M^-1 (B u - h - f) ],   p = exp(-w dt)

is the error of predicting the next reading with an observer of bandwidth w, the one of
``drive_machine``. Where the log is much finer than that observer, samples are averaged in blocks first,
which keeps what low frequencies say and divides the work. The measured acceleration is an output here, never a regressor: encoder noise is
white noise of e and does not pull inertias towards zero. M, h and the load of gravity are linear in
groups of inertial parameters and computed once per run; a prediction only sums, solves and filters.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from threading import Lock
from typing import TYPE_CHECKING

import numpy as np
from scipy.signal import butter, sosfiltfilt

from ...models import drive_kernels, rigid_tree_kernels
from ...models.joint import Joints
from . import floor as floors
from .machine import Array, Machine, RunData

if TYPE_CHECKING:
    from .clock import ReplayCheck
    from .effects import Form

Columns = Callable[[Array, Array], tuple[Array, Array, Array]]
SMOOTHING = 4.0  # cutoff of the smoothed state in observer bandwidths
BLOCK = 0.22  # of the time constant of the observer
SLOPE_STEP = 1e-4  # rad or m, and per second
EDGE = 3.0  # samples at the ends that do not count, in periods of the smoothing


@dataclass
class RigidPlant:
    """What forms change: inertial parameters by group, joints, actuators, sensors."""

    phi: Array  # (K,) values of the groups
    joints: Joints
    inputs: Array  # (n, m) efforts on the joints per delivered effort
    offset: Array  # (n,) reading at position zero
    scale: Array  # (n,) reading per true position
    time: float = 0.0  # how long the machine has been running [s]

    def finished(self) -> "RigidPlant":
        """The plant as ``predict`` needs it."""
        return self


class StateColumns:
    """Columns of the equation of motion at measured states (S, n), and to first order around them."""

    def __init__(self, columns: Columns, q: Array, v: Array) -> None:
        self._columns, self._q, self._v = columns, q, v
        self.mass, self.bias, self.load = columns(q, v)
        self._lock = Lock()
        self._by_position: list[tuple[Array, Array, Array]] = []
        self._by_rate: list[Array] = []

    def near(self, dq: Array, dv: Array) -> tuple[Array, Array, Array]:
        """Mass matrices, bias efforts and gravity loads at q + ``dq``, v + ``dv``, (S, n) each."""
        mass, bias, load = self.mass.copy(), self.bias.copy(), self.load.copy()
        with self._lock:
            if not self._by_position:
                self._by_position = [self._slopes(dq_i, 0.0 * dq_i) for dq_i in self._steps()]
            if np.any(dv != 0.0) and not self._by_rate:
                self._by_rate = [self._slopes(0.0 * dv_i, dv_i)[1] for dv_i in self._steps()]
        for i, (m, b, g) in enumerate(self._by_position):
            mass += dq[:, i, None, None, None] * m
            bias += dq[:, i, None, None] * b
            load += dq[:, i, None, None] * g
        if np.any(dv != 0.0):
            for i, b in enumerate(self._by_rate):
                bias += dv[:, i, None, None] * b
        return mass, bias, load

    def _steps(self) -> list[Array]:
        return [np.broadcast_to(SLOPE_STEP * e, self._q.shape) for e in np.eye(self._q.shape[1])]

    def _slopes(self, dq: Array, dv: Array) -> tuple[Array, Array, Array]:
        mass, bias, load = self._columns(self._q + dq, self._v + dv)
        return (
            (mass - self.mass) / SLOPE_STEP,
            (bias - self.bias) / SLOPE_STEP,
            (load - self.load) / SLOPE_STEP,
        )


@dataclass(frozen=True, kw_only=True)
class RigidRun(RunData):
    """A run in blocks of samples with all that does not depend on free parameters; arrays (blocks, n).

    ``command`` is (blocks, m), ``dt`` the time of a block, ``raw`` the run as it was logged.
    """

    raw: RunData
    block: int  # samples
    smooth: Array  # zero-phase smoothed positions
    rate: Array  # and their rates
    output: Array  # second differences of the positions
    equation: StateColumns  # masses (blocks, K, n, n), bias and load (blocks, K, n)


@dataclass(frozen=True, kw_only=True)
class RigidMachine(Machine):
    """Nominal model of a tree of rigid bodies with actuators on some joints."""

    actuated: tuple[str, ...]  # joints that the command's columns act on
    command_unit: str
    damping: Mapping[str, str]  # own parameter that is the viscous friction of a joint
    bandwidth: float  # of the prediction's correction [rad/s]
    plant: Callable[[Mapping[str, float]], RigidPlant]
    effects: "Callable[[RigidMachine, Sequence[RunData]], list[Form]]"
    loop: Callable[[RunData, RigidPlant], tuple[Array, Array] | None] = field(
        default=lambda run, plant: None
    )
    replayed: "Callable[[Sequence[RunData]], list[ReplayCheck]]" = field(default=lambda runs: [])

    def build(self, values: Mapping[str, float]) -> RigidPlant:
        """A fresh plant at the own parameters' values."""
        return self.plant(values)

    def predict(self, run: RunData, plant: RigidPlant) -> Array:
        """Prediction error (samples, n) of the encoders over the run's window [position unit]."""
        assert isinstance(run, RigidRun)
        smooth, rate, output = run.smooth, run.rate, run.output
        equation = run.equation
        mass, bias, load = equation.mass, equation.bias, equation.load
        if np.any(plant.offset != 0.0) or np.any(plant.scale != 1.0):
            smooth, rate = (smooth - plant.offset) / plant.scale, rate / plant.scale
            output = output / plant.scale
            mass, bias, load = equation.near(smooth - run.smooth, rate - run.rate)
        effort = np.empty_like(run.raw.command)
        rigid_tree_kernels.delivered(run.raw.command, plant.joints.actuator, run.raw.dt, effort)
        effort = block_means(effort, run.block)
        residual = np.empty_like(run.position)
        rigid_tree_kernels.residual(
            output, smooth, rate, effort, plant.inputs, mass, bias, load, plant.phi,
            plant.joints.law, float(np.exp(-self.bandwidth * run.dt)), run.dt, residual,
        )  # fmt: skip
        return np.asarray((residual * plant.scale)[run.window])

    def forms(self, runs: Sequence[RunData]) -> "list[Form]":
        """Every form that can act on this machine."""
        return self.effects(self, runs)

    def unexplained(self, residual: Array, run: RunData) -> Array:
        """Effort (k, n) that would cause a prediction error (k, n), at the run's mean posture."""
        assert isinstance(run, RigidRun)
        _, beta = drive_kernels.correction_gains(self.bandwidth, run.dt)
        mass = np.einsum("skij,k->ij", run.equation.mass, self.build(self.nominal()).phi) / len(
            run.t
        )
        return np.asarray(residual @ mass * (beta / run.dt))

    def floor(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> tuple[list[Array], str]:
        """Cycle-to-cycle repeatability, never below what the encoder's resolution does."""
        return floors.noise_floor(runs, residuals, self.bandwidth)

    def out_of_step(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> float | None:
        """What does not repeat, over the encoder's noise."""
        return floors.out_of_step(runs, residuals, self.bandwidth)

    def replays(self, runs: Sequence[RunData]) -> "list[ReplayCheck]":
        """Every run's logged command beside the stated controller's."""
        return self.replayed(runs)

    def simulate(self, run: RunData, plant: RigidPlant) -> tuple[Array, Array] | None:
        """Position and command of the whole loop; None where no law is stated."""
        assert isinstance(run, RigidRun)
        found = self.loop(run, plant)
        if found is None:
            return None
        return block_means(found[0], run.block), block_means(found[1], run.block)


def block_means(signal: Array, block: int) -> Array:
    """Means (S // block, ...) over consecutive blocks of samples of a signal (S, ...)."""
    if block == 1:
        return signal
    whole = len(signal) // block * block
    return np.ascontiguousarray(signal[:whole].reshape(-1, block, *signal.shape[1:]).mean(axis=1))


def prepared(run: RunData, columns: Columns, bandwidth: float) -> RigidRun:
    """The run in blocks, with smoothed states and the columns of the equation of motion."""
    cutoff = min(SMOOTHING * bandwidth / (2.0 * np.pi), 0.4 / run.dt)
    filter_ = butter(3, cutoff, fs=1.0 / run.dt, output="sos")
    smooth = sosfiltfilt(filter_, run.position, axis=0)
    rate = np.gradient(smooth, run.dt, axis=0)
    block = _block(bandwidth * run.dt, run.period)
    smooth, rate = block_means(smooth, block), block_means(rate, block)
    signals = ("t", "reference", "reference_rate", "reference_acceleration", "position", "command")
    means = {name: block_means(getattr(run, name), block) for name in signals}
    position, dt = means["position"], block * run.dt
    before, after = 2.0 * position[:1] - position[1:2], 2.0 * position[-1:] - position[-2:-1]
    padded = np.concatenate([before, position, after])  # a log may begin and end in motion
    edge = min(int(EDGE / (cutoff * dt)), len(position) // 10)
    changed = {
        **means,
        "dt": dt,
        "period": None if run.period is None else run.period // block,
        "lsb": run.lsb / np.sqrt(block),  # white noise of the resolution, averaged
        "window": slice(edge, len(position) - edge),
    }
    return RigidRun(
        **{**vars(run), **changed},
        raw=run,
        block=block,
        smooth=smooth,
        rate=rate,
        output=np.ascontiguousarray(np.diff(padded, 2, axis=0) / dt**2),
        equation=StateColumns(columns, smooth, rate),
    )


def _block(step: float, period: int | None) -> int:
    """Samples of a block: short beside the observer, and whole blocks in a period."""
    most = max(int(BLOCK / step), 1)
    return next(b for b in range(most, 0, -1) if period is None or period % b == 0)


def bandwidth_for(positions: Sequence[Array], dt: float, steps: Array, most: float) -> float:
    """Bandwidth [rad/s] at which the encoders' resolution hides about 2 % of the accelerations.

    ``steps`` (n,) are encoder steps; the result lies between 15 rad/s and ``most``.
    """
    cutoff = min(20.0, 0.2 / dt)
    filter_ = butter(3, cutoff, fs=1.0 / dt, output="sos")
    smooth = [sosfiltfilt(filter_, p, axis=0) for p in positions]
    size = np.sqrt(
        np.mean(np.concatenate([np.diff(s, 2, axis=0) for s in smooth]) ** 2, axis=0)
    ) / (dt * dt)
    noise = np.maximum(steps, 1e-9) / np.sqrt(12.0)
    return float(np.clip(np.sqrt(0.02 * np.min(size / noise)), 15.0, most))
