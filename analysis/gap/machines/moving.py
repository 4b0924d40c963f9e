"""Does a log show a machine at work at all? Where nothing moves, no model can be compared with it."""

from collections.abc import Sequence

import numpy as np

from ...errors import InputError
from ..description import FILE, MOVE_KINDS
from ..logset import LogSet
from ..machine import Machine, RunData


def refuse_still(logset: LogSet, machine: Machine, runs: Sequence[RunData]) -> None:
    """Refuse runs to fit to in which no position changes, or in which every command is zero."""
    fitted = [run for run in runs if run.use == "fit"]
    where = f"{logset.folder / FILE}, {', '.join(run.name for run in fitted)}"
    if logset.kind in MOVE_KINDS:  # whose moves are checked one by one
        return
    if not any(np.any(np.ptp(run.position, axis=0) > 0.0) for run in fitted):
        raise InputError(
            where,
            f"the measured positions of {', '.join(machine.joints)} never change",
            "a machine that moves in the runs to fit to",
            "Check which columns hold the measurement and that the machine was on.",
        )
    if not any(np.any(run.command) for run in fitted):
        raise InputError(
            where,
            "every command or effort is zero",
            f"the commands in {machine.effort_unit} that moved the machine",
            "Check which columns hold them.",
        )
