"""Machines by the name they have on the command line."""

from collections.abc import Callable

from .machine import RigMachine


def build(name: str, fault: str, seed: int) -> RigMachine:
    """The machine with a fault; InputError for an unknown fault, KeyError for an unknown machine."""
    from .c_drive import CDrive
    from .pmc import Carrier
    from .slider import Slider

    kinds: dict[str, Callable[[str, int], RigMachine]] = {
        "c-drive": CDrive,
        "slider": Slider,
        "pmc": Carrier,
    }
    return kinds[name](fault, seed)
