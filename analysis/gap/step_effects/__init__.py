"""Effects of stick-slip machines: every module of this folder that defines ``EFFECT`` is one."""

import importlib
import pkgutil
from collections.abc import Sequence
from functools import cache

from ..effects.base import Effect, Form
from ..step_machine import MoveRun, StepMachine
from .base import Moves, moves_of

__all__ = ["Moves", "catalogue", "forms_for", "moves_of"]


@cache
def catalogue() -> dict[str, Effect]:
    """All effects by id."""
    effects: dict[str, Effect] = {}
    for module in sorted(pkgutil.iter_modules(__path__), key=lambda m: m.name):
        found = getattr(importlib.import_module(f"{__name__}.{module.name}"), "EFFECT", None)
        if found is not None:
            effects[found.id] = found
    return effects


def forms_for(machine: StepMachine, runs: Sequence[MoveRun]) -> list[Form]:
    """Every form of every effect that these moves excite."""
    moves = moves_of(machine, runs)
    return [form for effect in catalogue().values() for form in effect.forms(machine, moves)]
