"""What the effects of dry friction share: levels by element and direction, and two laws."""

from collections.abc import Callable

import numpy as np

from ....models.drive import BACKWARD, FORWARD, STIFFNESS, WIDTH
from ..machine import Parameter
from .base import Scales, ShaftMachine, ShaftPlant, Values, parameter

MOST_SUBSTEPS = 8
STABLE = 2.0  # Runge-Kutta steps are kept below this many time constants of the smoothed sign


FAMILY = "dry friction"


def level_parameters(machine: ShaftMachine, scales: Scales) -> tuple[Parameter, ...]:
    """A level for each friction element."""
    return tuple(
        parameter(f"level_{e}", machine.unit("effort"), scales.effort, lower=0.0)
        for e in machine.elements
    )


def width_parameter(machine: ShaftMachine, scales: Scales) -> Parameter:
    """Speed over which the smoothed sign changes."""
    return parameter(
        "width",
        machine.unit("rate"),
        0.01 * scales.rate,
        lower=5e-4 * scales.rate,  # steeper signs ask for short steps; bristles are as sharp
        upper=0.2 * scales.rate,
        starts=(0.01 * scales.rate,),
    )


def travel_parameter(machine: ShaftMachine, scales: Scales) -> Parameter:
    """Elastic travel of bristles too short to be an effect of its own."""
    return parameter(
        "travel",
        machine.unit("position"),
        0.2 * scales.presliding_travel,
        lower=0.02 * scales.presliding_travel,
        upper=scales.presliding_travel,
        starts=(0.2 * scales.presliding_travel,),
    )


def asymmetry_parameter(name: str) -> Parameter:
    """The share that a level has more forward and less backward."""
    return parameter(name, "-", 0.3, lower=-1.0, upper=1.0)


def asymmetry_parameters(machine: ShaftMachine) -> tuple[Parameter, ...]:
    """An asymmetry for each friction element."""
    return tuple(asymmetry_parameter(f"asymmetry_{e}") for e in machine.elements)


def apply_smooth_sign(
    machine: ShaftMachine, scales: Scales
) -> Callable[[ShaftPlant, Values], None]:
    """Levels with a smoothed sign of the given width; short steps keep it stable."""

    def apply(plant: ShaftPlant, values: Values) -> None:
        _add_levels(plant, values, machine)
        plant.drive.element[:, WIDTH] = values["width"]
        keep_stable(plant, scales)

    return apply


def keep_stable(plant: ShaftPlant, scales: Scales) -> None:
    """Shorten the plant's steps to what the steepest smoothed sign asks for."""
    element = plant.drive.element
    steepest = float(np.max(element[:, (FORWARD, BACKWARD)].max(axis=1) / element[:, WIDTH]))
    fastest = steepest / float(np.linalg.eigvalsh(plant.inertia)[0])
    wanted = int(np.ceil(fastest * scales.dt / STABLE))
    plant.substeps = max(plant.substeps, min(wanted, MOST_SUBSTEPS))


def apply_bristles(machine: ShaftMachine, scales: Scales) -> Callable[[ShaftPlant, Values], None]:
    """Levels reached after an elastic travel, Dahl's law."""

    def apply(plant: ShaftPlant, values: Values) -> None:
        _add_levels(plant, values, machine)
        levels = plant.drive.element[:, (FORWARD, BACKWARD)]
        plant.drive.element[:, STIFFNESS] = levels.mean(axis=1) / values["travel"]

    return apply


def _add_levels(plant: ShaftPlant, values: Values, machine: ShaftMachine) -> None:
    for i, e in enumerate(machine.elements):
        level = values.get(f"level_{e}", 0.0)
        asymmetry = values.get(f"asymmetry_{e}", values.get("asymmetry", 0.0))
        plant.drive.element[i, FORWARD] += level * (1.0 + asymmetry)
        plant.drive.element[i, BACKWARD] += level * (1.0 - asymmetry)
