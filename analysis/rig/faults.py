"""What may be wrong with the machine behind the rig, for practice; never a key of its log sets."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...models import drive
from ...models.drive import Drive
from ..errors import InputError

MYSTERY = "mystery"


@dataclass(frozen=True, kw_only=True)
class Fault:
    """A fault by its name on the command line, the effect it is, and how it changes a plant."""

    name: str
    effect: str  # its id in the catalogue
    apply: Callable[[Any, float], None]  # to the plant, with the strength
    strength: tuple[float, float]  # drawn between
    unit: str


def _friction(plant: Drive, level: float) -> None:
    plant.element[:, drive.FORWARD] += level
    plant.element[:, drive.BACKWARD] += level


def _one_bearing(plant: Drive, level: float) -> None:
    plant.element[0, drive.FORWARD] += level
    plant.element[0, drive.BACKWARD] += level


def _shafts(column: int) -> Callable[[Drive, float], None]:
    def apply(plant: Drive, value: float) -> None:
        plant.shaft[:, column] = value

    return apply


def of_drive(effort: float, unit: str) -> Mapping[str, Fault]:
    """Faults of a drive with dry friction of the order of ``effort`` [unit]."""
    faults = (
        Fault(name="friction", effect="friction.coulomb", apply=_friction,
              strength=(0.7 * effort, 1.5 * effort), unit=unit),
        Fault(name="bearing", effect="friction.coulomb", apply=_one_bearing,
              strength=(effort, 2.0 * effort), unit=unit),
        Fault(name="bias", effect="load.bias", apply=_shafts(drive.BIAS),
              strength=(0.7 * effort, 1.5 * effort), unit=unit),
        Fault(name="weak", effect="actuator.torque_constant", apply=_shafts(drive.GAIN),
              strength=(0.75, 0.9), unit="-"),
        Fault(name="delay", effect="actuator.delay", apply=_shafts(drive.DELAY),
              strength=(1e-3, 3e-3), unit="s"),
    )  # fmt: skip
    return {fault.name: fault for fault in faults}


def choose(name: str, known: Mapping[str, Fault], rng: np.random.Generator) -> Fault | None:
    """The fault of this name, a drawn one for ``mystery``, none for ``none``; InputError for another name."""
    if name == "none":
        return None
    if name == MYSTERY:
        return known[str(rng.choice(sorted(known)))]
    if name not in known:
        raise InputError(
            "--fault", f"unknown fault {name!r}", f"one of none, {MYSTERY}, {', '.join(known)}"
        )
    return known[name]


def give(name: str, plant: Any, known: Mapping[str, Fault], seed: int) -> str:
    """Apply the fault to the plant; says what was done, for who gives up."""
    rng = np.random.default_rng(seed)
    fault = choose(name, known, rng)
    if fault is None:
        return "none: the machine is its nominal model"
    strength = float(rng.uniform(*fault.strength))
    fault.apply(plant, strength)
    return f"{fault.effect} ({fault.name}) of {strength:.4g} {fault.unit}"
