"""The catalogue of effects: every module of this folder that defines ``EFFECT`` is one.

``register`` adds an effect of your own; README.md shows how to write one in thirty lines.
"""

import importlib
import pkgutil
from functools import cache

from ..drive_machine import DriveMachine
from .base import Effect, Form, Scales, Scan, parameter, scales_of

__all__ = [
    "Effect",
    "Form",
    "Scales",
    "Scan",
    "catalogue",
    "forms_for",
    "parameter",
    "register",
    "scales_of",
    "scans_for",
]

_registered: dict[str, Effect] = {}


def register(effect: Effect) -> None:
    """Let later diagnoses try this effect, too; an id that is taken raises ValueError."""
    if effect.id in catalogue():
        raise ValueError(
            f"effect {effect.id!r} is already in the catalogue: {', '.join(sorted(catalogue()))}"
        )
    _registered[effect.id] = effect


def catalogue() -> dict[str, Effect]:
    """All effects by id."""
    return {**_built_in(), **_registered}


def forms_for(machine: DriveMachine, scales: Scales) -> list[Form]:
    """Every form of every effect that applies to this machine."""
    return [form for effect in catalogue().values() for form in effect.forms(machine, scales)]


def scans_for(machine: DriveMachine, scales: Scales) -> list[Scan]:
    """What is to be looked for on this machine."""
    return [e.scan(machine, scales) for e in catalogue().values() if e.scan is not None]


@cache
def _built_in() -> dict[str, Effect]:
    effects: dict[str, Effect] = {}
    for module in sorted(pkgutil.iter_modules(__path__), key=lambda m: m.name):
        found = getattr(importlib.import_module(f"{__name__}.{module.name}"), "EFFECT", None)
        if found is not None:
            effects[found.id] = found
    return effects
