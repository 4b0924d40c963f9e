"""Nominal models by ``system.kind``: one module per machine, each with ``read(logset)``."""

from collections.abc import Callable

from ...errors import InputError
from ..logset import LogSet
from ..machine import Machine, RunData
from . import c_drive, slider

KINDS: dict[str, Callable[[LogSet], tuple[Machine, list[RunData]]]] = {
    "c_drive": c_drive.read,
    "slider": slider.read,
}


def read_machine(logset: LogSet) -> tuple[Machine, list[RunData]]:
    """Nominal machine of a log set and its runs; InputError names an unknown kind or bad key."""
    if logset.kind not in KINDS:
        raise InputError(
            logset.folder, f"system.kind is {logset.kind!r}", f"one of {', '.join(sorted(KINDS))}"
        )
    return KINDS[logset.kind](logset)
