"""What the instrument needs to know of a machine: its nominal drive, own parameters and signals."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

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

    def finished(self) -> tuple[Drive, int]:
        """The drive for the kernels and its steps per sample."""
        inverse = np.linalg.inv(self.inertia)
        return self.drive._replace(inertia_inverse=np.ascontiguousarray(inverse)), self.substeps


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
