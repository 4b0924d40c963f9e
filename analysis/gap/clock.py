"""Replaying the stated controller on a log: does its law explain the logged command?

The replay needs no model of the machine, only the logged reference and position. ``signals`` uses it
to find clock offsets and wrong signals before anything is blamed on the machine.
"""

from dataclasses import dataclass

import numpy as np

from ...models import drive_kernels
from .machine import Array, RunData

AGREEMENT = 0.05  # rms difference of a faithful replay, relative to the rms command


@dataclass(frozen=True, kw_only=True)
class ReplayCheck:
    """Result for one run."""

    run: str
    disagreement: float  # rms command difference, relative to the rms command

    @property
    def faithful(self) -> bool:
        """Whether the stated control law explains the logged command."""
        return self.disagreement < AGREEMENT


def replay(run: RunData) -> Array:
    """Command (samples, n) of the stated controller for the logged reference and position.

    A controller that no drive has brings a method ``replay`` of its own.
    """
    if not isinstance(run.controller, drive_kernels.LoopController):
        return np.asarray(run.controller.replay(run))
    command = np.empty_like(run.command)
    drive_kernels.replay_controller(
        run.reference,
        run.reference_acceleration,
        run.position,
        run.controller,
        run.dt,
        drive_kernels.initial_memory(run.controller, run.position[0]),
        command,
    )
    return command


def check_replay(run: RunData) -> ReplayCheck:
    """How far the replayed command is from the logged one."""
    size = float(np.sqrt(np.mean(run.command**2))) or 1.0
    difference = float(np.sqrt(np.mean((replay(run) - run.command) ** 2)))
    return ReplayCheck(run=run.name, disagreement=difference / size)
