"""What a machine offers to the rig.

Motors carry the encoders and take the commands; axes are the directions in which one homes and jogs, and have the limit
switches. Both are linked by a constant matrix: axes = origin + A motors.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Axis:
    """One direction of motion; an axis without switches may move on for ever."""

    name: str
    unit: str  # m or rad
    speed: float  # at most, for jog and approach [unit/s]
    acceleration: float  # of jog, approach and halt [unit/s^2]
    low: float = -np.inf  # position of the negative limit switch [unit]
    high: float = np.inf  # of the positive one [unit]

    @property
    def switched(self) -> bool:
        """Whether it has limit switches."""
        return bool(np.isfinite(self.low) and np.isfinite(self.high))


@dataclass(frozen=True, kw_only=True)
class Layout:
    """The constant description of a machine."""

    kind: str  # ``system.kind`` of its log sets
    motors: tuple[str, ...]
    unit: str  # of the motors' positions, "rad or m" where they differ
    effort: str  # unit of the commands
    axes: tuple[Axis, ...]
    axis_map: Floats  # A (axes, motors)
    origin: Floats  # of the axes, (axes,)
    home: Floats  # of the motors, where trajectories start by default (motors,)
    finds_switch: bool  # homes on the negative switches; otherwise where it stands, by hand
    lsb: float | Floats  # of the encoders [unit], one or (motors,), 0 for exact ones
    following_error: float | Floats  # at most, one or (motors,) [unit]
    dt: float = 1e-3  # period of the controller [s]
    rate: float = 1.0  # of a trajectory to begin with [Hz]
    tables: bool = True  # whether trajectories may come as tables of samples

    def axis(self, motors: Floats) -> Floats:
        """Axis positions (axes,) of motor positions (motors,)."""
        return self.origin + self.axis_map @ motors

    def motor(self, axes: Floats) -> Floats:
        """Motor positions (motors,) of axis positions (axes,)."""
        return np.asarray(np.linalg.solve(self.axis_map, axes - self.origin), dtype=np.float64)


@dataclass(frozen=True, kw_only=True)
class Trajectory:
    """A sampled motion of the motors, (samples, motors) each, and what its run is called in the log set."""

    name: str
    position: Floats  # [unit]
    acceleration: Floats  # [unit/s^2]
    keys: Mapping[str, Any] = field(default_factory=dict)


class RigMachine(Protocol):
    """A simulated machine with its controller, one sample at a time."""

    layout: Layout
    programs: Sequence[str]  # names of built-in trajectories
    answer: str  # what is wrong with it, for who gives up

    def power_up(self, rng: np.random.Generator) -> None:
        """Stand still at a position the controller does not know."""

    def read(self) -> Floats:
        """Encoder readings (motors,) in the controller's coordinates."""

    def preset(self, motors: Floats) -> None:
        """Let the encoders read ``motors`` (motors,) here, to whole counts."""

    def true_axes(self) -> Floats:
        """Where the axes really are (axes,); only the limit switches use it."""

    def wake(self) -> None:
        """Start the controller's memory afresh at the present reading, the machine at rest."""

    def step(self, reference: Floats, acceleration: Floats) -> Floats:
        """One sample under power: the command (motors,) computed and held; moves the machine on."""

    def brake(self) -> None:
        """Stand still without power."""

    def settings(self) -> dict[str, Any]:
        """``controller`` and ``nominal`` blocks in use, in the words of the log set."""

    def configure(self, controller: Mapping[str, Any], nominal: Mapping[str, Any]) -> None:
        """Use other blocks, those keys that are given. InputError for a bad key; then nothing has changed."""

    def trajectory(self, name: str, rate: float, cycles: int) -> Trajectory:
        """A built-in trajectory; InputError for an unknown name or impossible numbers."""

    def columns(self) -> dict[str, str]:
        """Columns of a log and their units, ``t`` first, then as ``row`` gives them."""

    def row(
        self, time: float, reference: Floats, reading: Floats, command: Floats
    ) -> Sequence[float]:
        """One row of the log, its time in the run [s] first; empty where this sample logs nothing."""

    def document(self) -> dict[str, Any]:
        """``logset.yaml`` without name, columns and runs, with ``sample_time_s`` if the clock is even."""


@runtime_checkable
class WithFiles(Protocol):
    """A machine whose log sets need more files beside the tables."""

    def files(self) -> Mapping[str, str]:
        """Their text by name."""
