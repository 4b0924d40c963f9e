"""Whole-loop simulation beside the log: the stated controller runs on the model instead."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .hypothesis import Fit
from .machine import Machine, RunData, rms


def closed_loop(
    machine: Machine, runs: Sequence[RunData], fits: Mapping[str, Fit]
) -> dict[str, Any]:
    """Whole-loop simulation beside the log: rms differences of command and position, by model.

    The controller runs on the model instead of on the log. Differences are relative to the rms of the
    measured command and in position units; None where a simulation diverges,
    empty where the machine has no loop to simulate.
    """
    result: dict[str, Any] = {}
    for name, fit in fits.items():
        command_error, position_error = [], []
        for run in runs:
            plant = fit.hypothesis.plant(machine, fit.by_key(), run.start)
            loop = machine.simulate(run, plant)
            if loop is None:
                return {}
            position, command = loop
            command_error.append((command - run.command)[run.window])
            position_error.append((position - run.position)[run.window])
        size = rms([run.command[run.window] for run in runs])
        with np.errstate(over="ignore"):  # what overflows has diverged
            errors = {
                "relative_command_error": rms(command_error) / size,
                f"position_error_{machine.position_unit}": rms(position_error),
            }
        result[name] = errors if np.all(np.isfinite(list(errors.values()))) else None
    return result
