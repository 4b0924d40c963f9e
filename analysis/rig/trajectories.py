"""Trajectories from the user: a built-in one by name, a motion file, or a table of samples."""

import io
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..errors import InputError
from ..gap.machines.reference import derivatives
from .machine import Floats, RigMachine, Trajectory

LONGEST = 600.0  # [s]
KEYS = {"name", "rate_Hz", "cycles", "csv"}


def load(machine: RigMachine, data: Mapping[str, Any]) -> Trajectory:
    """The trajectory described by ``data``; InputError if it cannot be followed.

    Either ``name`` with ``rate_Hz`` and ``cycles``, or ``csv``: text with the columns t [s] and one per motor, sampled
    at the controller's period.
    """
    unknown = sorted(set(data) - KEYS)
    if unknown:
        raise InputError(
            "trajectory", f"unknown key {unknown[0]!r}", f"one of {', '.join(sorted(KEYS))}"
        )
    if "csv" in data and not machine.layout.tables:
        raise InputError("trajectory", "a table", f"a motion: {', '.join(machine.programs)}")
    if "csv" in data:
        found = _from_table(machine, str(data["csv"]))
    else:
        rate, cycles = data.get("rate_Hz", machine.layout.rate), data.get("cycles", 3)
        for name, value, kind in (("rate_Hz", rate, int | float), ("cycles", cycles, int)):
            if isinstance(value, bool) or not isinstance(value, kind):
                raise InputError("trajectory", f"{name} is {value!r}", "a number")
        found = machine.trajectory(str(data.get("name", "")), float(rate), cycles)
    _refuse_unreachable(machine, found)
    return found


def _from_table(machine: RigMachine, text: str) -> Trajectory:
    layout = machine.layout
    wanted = f"columns t, {', '.join(layout.motors)} with a header"
    try:
        names = text.splitlines()[0].replace(" ", "").split(",")
        table = np.loadtxt(io.StringIO(text), delimiter=",", skiprows=1, ndmin=2)
    except (ValueError, IndexError) as error:
        raise InputError("trajectory table", str(error), wanted) from None
    if names != ["t", *layout.motors] or table.shape[1] != len(names):
        raise InputError("trajectory table", f"columns {', '.join(names)}", wanted)
    if not np.isfinite(table).all():
        raise InputError("trajectory table", "a value that is not finite", "numbers only")
    t, position = table[:, 0], np.ascontiguousarray(table[:, 1:])
    if not 10 <= len(t) <= LONGEST / layout.dt:
        raise InputError("trajectory table", f"{len(t)} rows", f"10 to {LONGEST / layout.dt:.0f}")
    if np.max(np.abs(np.diff(t) - layout.dt)) > 1e-3 * layout.dt:
        raise InputError("trajectory table", "another sample time", f"{layout.dt} s throughout")
    _, acceleration = derivatives(position, layout.dt)
    return Trajectory(
        name="table", position=position, acceleration=acceleration, keys={"note": "a table"}
    )


def _refuse_unreachable(machine: RigMachine, trajectory: Trajectory) -> None:
    axes: Floats = machine.layout.origin + trajectory.position @ machine.layout.axis_map.T
    for i, axis in enumerate(machine.layout.axes):
        low, high = axes[:, i].min(), axes[:, i].max()
        if low <= axis.low or high >= axis.high:
            raise InputError(
                f"trajectory {trajectory.name}",
                f"axis {axis.name} goes from {low:.4g} to {high:.4g} {axis.unit}",
                f"between the switches at {axis.low:g} and {axis.high:g} {axis.unit}",
            )
