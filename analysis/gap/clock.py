"""Are the columns of a log on one clock? The known controller says so, without any plant model.

The controller's law is replayed on the logged reference and position. Its command agrees with the
logged one at the lag at which the log was written; a lag other than zero is an offset of the log,
not a delay of the machine, and is removed before anything is blamed on the machine.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...models import drive_kernels
from .machine import Array, RunData

LARGEST_LAG = 5  # samples
AGREEMENT = 0.05  # rms difference of a faithful replay, relative to the rms command


@dataclass(frozen=True, kw_only=True)
class ClockCheck:
    """Result for one run."""

    run: str
    lag: int  # samples by which the logged command is late
    disagreement: float  # rms command difference at that lag, relative to the rms command
    faithful: bool  # whether the stated control law explains the logged command


def replay(run: RunData) -> Array:
    """Command (samples, n) of the stated controller for the logged reference and position."""
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


def check_clock(run: RunData) -> ClockCheck:
    """Lag between position and command columns at which the control law fits best."""
    expected = replay(run)
    size = float(np.sqrt(np.mean(run.command**2))) or 1.0
    inner = slice(LARGEST_LAG + 50, len(expected) - LARGEST_LAG)
    errors = {
        lag: float(
            np.sqrt(np.mean((run.command[inner] - np.roll(expected, lag, axis=0)[inner]) ** 2))
        )
        for lag in range(-LARGEST_LAG, LARGEST_LAG + 1)
    }
    lag = min(errors, key=lambda k: (errors[k], abs(k)))
    if errors[lag] > 0.8 * errors[0]:
        lag = 0
    return ClockCheck(
        run=run.name,
        lag=lag,
        disagreement=errors[lag] / size,
        faithful=errors[lag] < AGREEMENT * size,
    )


def align(runs: Sequence[RunData]) -> tuple[list[RunData], list[ClockCheck]]:
    """Runs with a common lag of faithful controllers removed, and what was found in each."""
    checks = [check_clock(run) for run in runs]
    trusted = {check.lag for check in checks if check.faithful}
    if len(trusted) != 1 or trusted == {0}:
        return list(runs), checks
    lag = trusted.pop()
    return [_shifted(run, lag) for run in runs], checks


def _shifted(run: RunData, lag: int) -> RunData:
    """The run with its command moved ``lag`` samples earlier; the ends that lack a partner are cut."""
    late = slice(max(lag, 0), len(run.t) + min(lag, 0))
    early = slice(max(-lag, 0), len(run.t) - max(lag, 0))
    return replace(
        run,
        t=run.t[early],
        reference=run.reference[early],
        reference_rate=run.reference_rate[early],
        reference_acceleration=run.reference_acceleration[early],
        position=np.ascontiguousarray(run.position[early]),
        command=np.ascontiguousarray(run.command[late]),
    )
