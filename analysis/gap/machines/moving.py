"""Does a log show a machine at work at all? Where nothing moves, no model can be compared with it."""

from collections.abc import Sequence

import numpy as np

from ...errors import InputError
from ..description import FILE, MOVE_KINDS
from ..logset import LogSet
from ..machine import Array, Machine, RunData


def refuse_still(logset: LogSet, machine: Machine, runs: Sequence[RunData]) -> None:
    """Refuse runs to fit to in whose windows no position changes, or in which every command is zero."""
    fitted = [run for run in runs if run.use == "fit"]
    where = f"{logset.folder / FILE}, {', '.join(run.name for run in fitted)}"
    if logset.kind in MOVE_KINDS:  # whose moves are checked one by one
        return
    if not any(_changes(run.position[run.window]) for run in fitted):
        raise InputError(
            where,
            f"the measured positions of {', '.join(machine.joints)} never change",
            "a machine that moves in the runs to fit to",
            _elsewhere(any(_changes(run.position) for run in fitted))
            or "Check which columns hold the measurement and that the machine was on.",
        )
    if not any(np.any(run.command[run.window]) for run in fitted):
        raise InputError(
            where,
            "every command or effort is zero",
            f"the commands in {machine.effort_unit} that moved the machine",
            _elsewhere(any(np.any(run.command) for run in fitted))
            or "Check which columns hold them.",
        )


def _changes(position: Array) -> bool:
    """Whether any of the positions (samples, n) changes."""
    return bool(np.any(np.ptp(position, axis=0) > 0.0))


def _elsewhere(found: bool) -> str:
    """What to do where the rest of the runs, which is not fitted to, holds what is missing."""
    return (
        "The end of each run is held back for validation, and only it moves: mark a run `use: validate` to "
        "have the others used whole, or cut what is at rest."
        if found
        else ""
    )
