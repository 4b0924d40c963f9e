"""What an effect is: an id of the catalogue and one or more mathematical forms to fit."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np

from ....models.drive import Drive
from ...errors import InputError
from ..machine import Array, Parameter, RunData

DRY_FRICTION = frozenset({"friction.coulomb"})  # what Stribeck friction contains
RARE = 0.03  # price of a form that a plainer one nearly contains


@dataclass(frozen=True, kw_only=True)
class Scales:
    """Typical sizes of a log set, from which forms derive bounds and starts."""

    effort: float  # rms of the command
    effort_peak: float  # largest command
    rate: float  # rms of the reference rate
    rate_peak: float
    travel: float  # range of the position
    lsb: float  # encoder step, or 1e-6 of the travel where none can be seen

    @property
    def presliding_travel(self) -> float:
        """Elastic travel from which on it is an effect of its own, not the corner of dry friction."""
        return max(4.0 * self.lsb, 1e-4 * self.travel)

    dt: float  # [s]
    duration: float  # from the start of the first run to that of the last, 0 if not known [s]


def scales_of(runs: Sequence[RunData]) -> Scales:
    """Typical sizes of some runs."""
    command = np.concatenate([run.command[run.window] for run in runs])
    rate = np.concatenate([run.reference_rate[run.window] for run in runs])
    position = np.concatenate([run.position[run.window] for run in runs])
    travel = float(np.ptp(position))
    if not np.any(rate):
        raise InputError(
            ", ".join(run.name for run in runs),
            "the reference never moves in any of these runs",
            "a fit run with a motion",
            "Log a motion of the machine: at rest nothing can be told apart.",
        )
    return Scales(
        effort=float(np.sqrt(np.mean(command**2))),
        effort_peak=float(np.max(np.abs(command))),
        rate=float(np.sqrt(np.mean(rate**2))),
        rate_peak=float(np.max(np.abs(rate))),
        travel=travel,
        dt=runs[0].dt,
        duration=max(run.start for run in runs) - min(run.start for run in runs),
        lsb=runs[0].lsb or 1e-6 * travel,
    )


Values = Mapping[str, float]


class ShaftMachine(Protocol):
    """A machine behind shafts with the actuators and friction elements of ``models.drive``."""

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the shafts."""

    @property
    def elements(self) -> tuple[str, ...]:
        """Friction elements; the first n are the shafts' own bearings."""

    @property
    def viscous_own(self) -> tuple[str, ...]:
        """Own parameter that is the viscous friction of each element."""

    @property
    def ripples(self) -> Mapping[str, float]:
        """Spatial frequencies [1/position unit] by the name of a period."""

    def unit(self, quantity: str) -> str:
        """Unit of a quantity: effort, rate, viscous or stiffness."""


class ShaftPlant(Protocol):
    """What the effects of actuators and friction change."""

    inertia: Array  # (shafts, shafts) felt at the shafts
    drive: Drive
    substeps: int
    time: float
    sensor_scale: Array | None


@dataclass(frozen=True, kw_only=True)
class Form:
    """One mathematical form of an effect on one machine.

    ``apply`` changes a plant by the values of ``parameters``; a value left out is zero, no effect.
    Parameters in ``removable`` may be dropped one by one when the data do not need them.
    ``replaces`` names own parameters of the machine that stay at their nominal value because the form
    takes their place; ``takes`` those whose place one of its parameters takes where it is not dropped.
    ``amounts_to`` says which form of another effect, with as many parameters in the same order, some values make
    of it, or None.
    """

    effect: str
    name: str
    parameters: tuple[Parameter, ...]
    apply: Callable[[Any, Values], None]  # changes the plant of the machine the form is for
    where: Callable[[Sequence[str]], dict[str, Any]]
    removable: frozenset[str] = frozenset()
    replaces: frozenset[str] = frozenset()
    takes: Mapping[str, str] = field(default_factory=dict)  # own parameters by parameter
    shapes: frozenset[str] = frozenset()  # parameters that matter only once others are not zero
    family: str = ""  # forms of one family describe the same contact and never act together
    own_start: bool = False  # values of the effect's other forms mean something else here
    refined: bool = False  # a richer version of another form, tried once that form is chosen
    stands_for: frozenset[str] = frozenset()  # effects that a refined form may make needless
    contains: frozenset[str] = frozenset()  # effects that it is at the edge of its parameters
    price: float = 0.0  # further fall of the log residual asked of a form that is rarely the reason
    shifts: bool = False  # whether it moves the command in time, and so every impact that follows
    least: Mapping[str, float] = field(default_factory=dict)  # up to these values it is no effect
    step: float = 0.0  # finite-difference step in parameter scales, where the default is too fine
    amounts_to: "Callable[[Values], Form | None]" = lambda values: None


@dataclass(frozen=True, kw_only=True)
class Scan:
    """Values of a shape, neighbours closer than runs can tell apart, and the form that starts from one of them."""

    effect: str  # its id
    shape: str  # name of the parameter
    values: Array
    form: Callable[[float], Form]


@dataclass(frozen=True, kw_only=True)
class Effect:
    """A physical mechanism of EFFECTS.md and how to try it on a machine."""

    id: str
    summary: str
    forms: Callable[[Any, Any], list[Form]]  # of the machine and its scales
    # What the unexplained torque of a machine with this effect looks like, for the report.
    signature: str
    # Forms that differ in a shape only, such as a period, to be looked for in what a fit leaves.
    scan: Callable[[Any, Any], Scan] | None = None  # of the machine and its scales


def parameter(
    name: str,
    unit: str,
    scale: float,
    *,
    lower: float = -np.inf,
    upper: float = np.inf,
    starts: Sequence[float] | None = None,
    seconds: Sequence[float] = (),
) -> Parameter:
    """A parameter that starts from zero, no effect, unless told otherwise."""
    return Parameter(
        name=name,
        unit=unit,
        lower=lower,
        upper=upper,
        scale=scale,
        starts=tuple(starts) if starts is not None else (0.0,),
        seconds=tuple(seconds),
    )


def at(kind: str, prefix: str) -> Callable[[Sequence[str]], dict[str, Any]]:
    """Places from the names of the parameters that stayed: ``level_left`` acts at ``left``."""

    def where(names: Sequence[str]) -> dict[str, Any]:
        places = [name.removeprefix(prefix) for name in names if name.startswith(prefix)]
        return {kind: places}

    return where


def everywhere(kind: str, places: Sequence[str]) -> Callable[[Sequence[str]], dict[str, Any]]:
    """The same places whatever parameters stayed."""
    return lambda names: {kind: list(places)}
