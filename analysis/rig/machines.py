"""Machines by the name they have on the command line."""

from collections.abc import Callable
from functools import partial
from importlib import import_module
from typing import TYPE_CHECKING

from ..errors import InputError

if TYPE_CHECKING:  # the command line reads the names, and NumPy would slow it down
    from .machine import RigMachine

Builder = Callable[[str, int], "RigMachine"]
CHAINS = ("5r", "replalink", "2prr", "mast", "3prs")
OTHERS = {
    "c-drive": ("c_drive", "CDrive"),
    "slider": ("slider", "Slider"),
    "pmc": ("pmc", "Carrier"),
    "mm3a": ("mm3a", "Manipulator"),
    "furuta": ("furuta", "Furuta"),
    "arm": ("arm", "Arm"),
}
NAMES = (*OTHERS, *CHAINS)


def build(name: str, fault: str, seed: int) -> "RigMachine":
    """The machine with a fault; InputError for an unknown machine or fault."""
    if name not in NAMES:
        raise InputError("rig", f"unknown machine {name!r}", f"one of {', '.join(NAMES)}")
    return _builder(name)(fault, seed)


def _builder(name: str) -> Builder:
    if name in CHAINS:
        from .chain import ChainDrive
        from .chains import CHAINS as known

        return partial(ChainDrive, known[name])
    module, kind = OTHERS[name]
    found: Builder = getattr(import_module(f".{module}", __package__), kind)
    return found
