"""What the instrument needs to know of a machine: its nominal drive, own parameters and signals."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...models.drive import Drive
from ...models.drive_kernels import LoopController

Array = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class Parameter:
    """A free parameter of a fit: unit, bounds, typical size and the values a search starts from."""

    name: str
    unit: str
    lower: float
    upper: float
    scale: float  # typical size, sets finite-difference steps and trust regions
    starts: tuple[float, ...]


@dataclass
class Plant:
    """The drive that effects act on; its inverse inertia is taken after all of them have acted."""

    inertia: Array  # (shafts, shafts)
    drive: Drive
    substeps: int = 1
    time: float = 0.0  # how long the machine has been running [s]
    sensor_scale: Array | None = None  # (n,) reading per true position, None for exact encoders

    def finished(self) -> "FinishedPlant":
        """The plant as the kernels need it."""
        inverse = np.ascontiguousarray(np.linalg.inv(self.inertia))
        drive = self.drive._replace(inertia_inverse=inverse)
        return FinishedPlant(drive, self.substeps, self.sensor_scale)


class FinishedPlant(NamedTuple):
    """A plant whose effects have all acted."""

    drive: Drive
    substeps: int  # integration steps per sample
    sensor_scale: Array | None


@dataclass(frozen=True, kw_only=True)
class PayloadAxis:
    """One way a wrong or added mass shows: the inertia matrix of one unit of it."""

    name: str  # parameter name, such as collar_mass
    unit: str
    inertia: Array  # (n, n) per unit
    own: str  # the machine's own parameter it stands in for
    scale: float


@dataclass(frozen=True, kw_only=True)
class RunData:
    """One run as the kernels need it; arrays are (samples, n)."""

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
    controller: LoopController
    period: int | None  # samples of one repeated cycle, if the motion repeats
    lsb: float  # encoder step found in the data, 0 if it cannot be seen
    start: float = 0.0  # how long the machine had been running when the run began [s]
    window: slice = field(
        default_factory=lambda: slice(None)
    )  # samples that count; the rest only leads up to them


@dataclass(frozen=True, kw_only=True)
class Machine:
    """Nominal model of a machine whose drive the kernels can run.

    ``build`` maps the own parameters' values, by name, to a fresh plant.
    """

    kind: str
    shafts: tuple[str, ...]
    elements: tuple[str, ...]  # friction elements; the first n are the shafts' own bearings
    task: tuple[str, ...]  # task coordinates
    task_map: Array  # (len(task), n), per shaft position
    position_unit: str
    effort_unit: str
    own: tuple[Parameter, ...]  # nominal values are their first starts, bounds their tolerance
    payload: tuple[PayloadAxis, ...]
    viscous_own: tuple[str, ...]  # own parameters that are viscous friction
    ripples: Mapping[str, float]  # spatial frequencies [1/position unit] by the name of a period
    motor_share: float  # share of the smallest inertia that sits on the motor's side
    bandwidth: float  # of the prediction's correction [rad/s]
    build: Callable[[Mapping[str, float]], Plant]

    def nominal(self) -> dict[str, float]:
        """Nominal values of the own parameters."""
        return {p.name: p.starts[0] for p in self.own}

    def unit(self, quantity: str) -> str:
        """Unit of a quantity: effort, rate, viscous, inertia or stiffness."""
        angle, effort = self.position_unit, self.effort_unit
        units = {
            "position": angle,
            "effort": effort,
            "rate": f"{angle}/s",
            "viscous": f"{effort} s/{angle}",
            "stiffness": f"{effort}/{angle}",
        }
        return units[quantity]


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
