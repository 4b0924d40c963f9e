"""Nominal models by ``system.kind``: one module per machine, each with ``read(logset)``."""

import sys
from collections.abc import Callable, Mapping

from ...errors import InputError
from ..description import FILE, MODEL_FILE
from ..logset import LogSet
from ..machine import Machine, RunData
from . import (
    c_drive,
    furuta,
    mm3a,
    model_file,
    parallel,
    pendulum,
    piezo_stack,
    pmc,
    serial_arm,
    slider,
)
from .encoders import stated_encoder_step
from .moving import refuse_still

__all__ = [
    "KINDS",
    "UNEVEN",
    "columns_of",
    "read_machine",
    "refuse_still",
    "stated_encoder_step",
]

KINDS: dict[str, Callable[[LogSet], tuple[Machine, list[RunData]]]] = {
    "c_drive": c_drive.read,
    "furuta": furuta.read,
    "mm3a": mm3a.read,
    MODEL_FILE: model_file.read,
    "pendulum": pendulum.read,
    "piezo_stack": piezo_stack.read,
    "pmc": pmc.read,
    "serial_arm": serial_arm.read,
    "slider": slider.read,
    **{kind: parallel.reader(kind) for kind in parallel.KINDS},
}
UNEVEN = frozenset({"pendulum"})  # kinds whose samples may come at uneven times


def columns_of(kind: str) -> Mapping[str, str] | None:
    """Columns that every log set of a kind has, with their units; None where they vary.

    Raises InputError for an unknown kind.
    """
    if kind not in KINDS:
        raise InputError("kind", repr(kind), f"one of {', '.join(sorted(KINDS))}")
    return getattr(sys.modules[KINDS[kind].__module__], "COLUMNS", None)


def read_machine(logset: LogSet) -> tuple[Machine, list[RunData]]:
    """Nominal machine of a log set and its runs; InputError names an unknown kind or bad key."""
    if logset.kind not in KINDS:
        raise InputError(
            logset.folder / FILE,
            f"system.kind is {logset.kind!r}",
            f"one of {', '.join(sorted(KINDS))}",
            "State what the machine is there, and its constants under system.nominal.",
        )
    if logset.uneven and logset.kind not in UNEVEN:
        raise InputError(
            logset.folder / FILE,
            f"an uneven clock, but system.kind is {logset.kind}",
            f"sample_time_s in seconds; uneven samples are read for {', '.join(sorted(UNEVEN))}",
            "State sample_time_s in seconds and `resample: linear` in logset.yaml.",
        )
    stated_encoder_step(logset)
    machine, runs = KINDS[logset.kind](logset)
    refuse_still(logset, machine, runs)
    return machine, runs
