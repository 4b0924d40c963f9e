"""What the instrument needs to know of a machine: own parameters, signals, and how it is predicted."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .floor import repeatability_floor

if TYPE_CHECKING:
    from .clock import ReplayCheck
    from .effects import Effect, Form, Scan
    from .inverse_model import Structure
    from .law_error import LawError
    from .signals import SignalFinding

Array = NDArray[np.float64]
STILL = 0.02  # of the largest speed: less is standstill


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A free parameter of a fit: unit, bounds, typical size and the values a search starts from."""

    name: str
    unit: str
    lower: float
    upper: float
    scale: float  # typical size, sets finite-difference steps and trust regions
    starts: tuple[float, ...]
    seconds: tuple[float, ...] = ()  # tried in place of the starts, from the best of all starts


@dataclass(frozen=True, kw_only=True)
class RunData:
    """One run; arrays are (samples, n). A machine that needs more signals subclasses it."""

    name: str
    use: str
    settings: Mapping[str, Any]
    dt: float  # [s]
    t: Array  # (samples,) [s]
    reference: Array
    reference_rate: Array
    reference_acceleration: Array
    position: Array
    command: Array
    controller: Any  # as the machine's closed loop needs it, None where no law is stated
    period: int | None  # samples of one repeated cycle, if the motion repeats
    lsb: float  # encoder step found in the data, 0 if it cannot be seen
    shifted: float = 0.0  # samples that positions were moved by linear interpolation
    start: float = 0.0  # how long the machine had been running when the run began [s]
    window: slice = field(
        default_factory=lambda: slice(None)
    )  # samples that count; the rest only leads up to them


@dataclass(frozen=True, kw_only=True)
class Machine(ABC):
    """Nominal model of a machine, and how it is predicted.

    One subclass a way of predicting; the pipeline asks for nothing beyond what stands here. A residual
    is white measurement noise where the model is right; a prediction that diverges holds NaN or inf.
    """

    kind: str
    joints: tuple[str, ...]  # names of the residual's columns
    position_unit: str
    effort_unit: str
    own: tuple[Parameter, ...]  # nominal values are their first starts, bounds their tolerance

    @abstractmethod
    def build(self, values: Mapping[str, float]) -> Any:
        """A fresh plant at the own parameters' values; forms change it, ``finished`` ends that.

        It has an attribute ``time``, how long the machine has been running [s].
        """

    @abstractmethod
    def predict(self, run: RunData, plant: Any) -> Array:
        """Residual (samples, n) of a finished plant over the window of the run [residual unit]."""

    def predict_all(
        self, tasks: Sequence[tuple[RunData, Any]], submit: Callable[..., Future[Any]]
    ) -> list[Array]:
        """``predict`` of every run and plant, each ``submit``-ted to threads."""
        return [future.result() for future in [submit(self.predict, *task) for task in tasks]]

    @abstractmethod
    def forms(self, runs: Sequence[RunData]) -> "list[Form]":
        """Every form of every effect that can act on this machine, scaled to the runs."""

    def scans(self, runs: Sequence[RunData]) -> "list[Scan]":
        """Shapes, such as a period, that are looked for in what a fit leaves."""
        return []

    def catalogue(self) -> "Mapping[str, Effect]":
        """Effects by id that machines of this sort can have, for the words of the report."""
        from .effects import catalogue

        return catalogue()

    def locate(
        self, runs: Sequence[RunData], residuals: Sequence[Array], seed: int
    ) -> dict[str, list[dict[str, Any]]]:
        """Shares of the gap as in FORMAT.md, each list summing to 1."""
        from .location import locate

        return locate(runs, residuals, self, seed)

    @property
    def places(self) -> tuple[str, ...]:
        """Names of what an effect may act on; one name is left unsaid."""
        return self.joints

    @property
    def designable(self) -> bool:
        """Whether ``gapscope design`` can find a motion for this machine."""
        return False

    @property
    def residual_unit(self) -> str:
        """Unit of what ``predict`` returns."""
        return self.position_unit

    @property
    def metric(self) -> str:
        """What ``unexplained`` measures, in words."""
        return f"rms unexplained {self.effort_unit} on held-out runs"

    @property
    def task_rows(self) -> tuple[tuple[str, ...], Array]:
        """Names of the task coordinates and their rows (task, n) over the joints."""
        return self.joints, np.eye(len(self.joints))

    @property
    def law_error(self) -> "LawError | None":
        """How far the law and its effects are from the machine; None where they are taken as exact."""
        return None

    def nominal(self) -> dict[str, float]:
        """Nominal values of the own parameters."""
        return {p.name: p.starts[0] for p in self.own}

    def spread(self, runs: Sequence[RunData]) -> float:
        """Rms of the signal that is predicted [residual unit]: a residual above it explains nothing."""
        return rms([(run.position - run.position.mean(axis=0))[run.window] for run in runs])

    def unexplained(self, residual: Array, run: RunData) -> Array:
        """What would cause a residual (k, n), a linear map of its rows: efforts where they are known."""
        return residual

    def floor(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> tuple[list[Array], str]:
        """Floor samples (k, n) of every run [residual unit] and how they were found."""
        return repeatability_floor(runs, residuals)

    def settling(self, run: RunData) -> int:
        """Samples at the beginning of a run whose residual shows the unknown first state, not the machine."""
        return 0

    def out_of_step(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> float | None:
        """How many times what does not repeat exceeds measurement noise; None where unknown."""
        return None

    def examine(
        self, runs: Sequence[RunData], stated_step: float | None
    ) -> "tuple[list[RunData], list[SignalFinding]]":
        """The runs with wrong signals corrected, and what was found; ``stated_step`` of the encoder."""
        return list(runs), []

    def replays(self, runs: Sequence[RunData]) -> "list[ReplayCheck]":
        """How well the stated controller reproduces the logged command, where one is stated."""
        return []

    def simulate(self, run: RunData, plant: Any) -> tuple[Array, Array] | None:
        """Position and command (samples, n) of the whole loop; None where no law is stated."""
        return None

    def remarks(self, runs: Sequence[RunData]) -> list[str]:
        """What signals that no fit uses say of the runs, one sentence each."""
        return []

    def inverse_model(self, runs: Sequence[RunData]) -> "list[Structure]":
        """Relative effort errors of growing structures; empty where there is no such regression."""
        return []


def own_parameter(name: str, unit: str, value: float, tolerance: float) -> Parameter:
    """A nominal parameter that may move by its relative tolerance."""
    return Parameter(
        name=name,
        unit=unit,
        lower=value * (1.0 - tolerance),
        upper=value * (1.0 + tolerance),
        scale=abs(value),
        starts=(value,),
    )


def starts_in_motion(run: RunData) -> bool:
    """Whether the reference moves when the run begins, so that the first speed is not zero."""
    rate = np.abs(run.reference_rate)
    return bool(np.any(rate[0] > STILL * np.max(rate)))


def encoder_step(position: Array) -> float:
    """Encoder step seen in the data: the value all readings are multiples of; 0 if there is none.

    Positions printed with few digits are multiples of the last digit, which is then the step.
    """
    levels = np.unique(np.round(position.ravel(), 12))
    if levels.size < 3:
        return 0.0
    gaps = np.diff(levels)
    step = float(np.quantile(gaps, 0.05))
    ratio = gaps[gaps < 20.0 * step] / step
    regular = np.abs(ratio - np.round(ratio)) < 0.05
    return float(np.median(gaps[gaps < 1.5 * step])) if np.mean(regular) > 0.9 else 0.0


def rms(values: Sequence[Array]) -> float:
    """Root mean square of all values of some arrays."""
    return float(np.sqrt(np.mean(np.concatenate([v.ravel() for v in values]) ** 2)))
