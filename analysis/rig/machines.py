"""Machines by the name they have on the command line."""

from collections.abc import Callable
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

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
    "pendulum": ("pendulum", "Pendulum"),
    "piezo": ("piezo", "Piezo"),
}
NAMES = (*OTHERS, *CHAINS)
MODEL_FILES = (".urdf", ".sdf")


def build(name: str, fault: str, seed: int, **model: Any) -> "RigMachine":
    """The machine with a fault; InputError for an unknown machine or fault.

    ``name`` may be an .urdf or .sdf file; ``model`` are then options of ``model.ModelArm``.
    """
    if Path(name).suffix.lower() in MODEL_FILES:
        from .model import ModelArm

        return ModelArm(Path(name), fault, seed, **model)
    if name not in NAMES:
        raise InputError(
            "rig",
            f"unknown machine {name!r}",
            f"one of {', '.join(NAMES)}, or an .urdf or .sdf file",
        )
    for option, value in model.items():
        if value:
            raise InputError(f"--{option}", f"given for {name}", "a model file as the machine")
    return _builder(name)(fault, seed)


def _builder(name: str) -> Builder:
    if name in CHAINS:
        from .chain import ChainDrive
        from .chains import CHAINS as known

        return partial(ChainDrive, known[name])
    module, kind = OTHERS[name]
    found: Builder = getattr(import_module(f".{module}", __package__), kind)
    return found
