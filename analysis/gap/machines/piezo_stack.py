"""Nominal model of a piezo stack in open loop (``system.kind: piezo_stack``): length per volt.

``system.nominal`` states ``gain_um_per_V``, ``offset_um`` and ``rest_V``, the command before the first
sample; what is left out is taken from the fit data as ``read`` says, and then cannot be found wrong. The
residual is measured less simulated length: nothing corrects the simulation.

Not tried on this machine: resonance of the stage, load on the stack, hysteresis that depends on the
rate. A command of one amplitude and frequency tells little of how hysteresis grows with either.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ....models import piezo_stack_kernel
from ....models.piezo_stack import DECADES, PiezoStack, linear_stack
from ...errors import InputError
from ..floor import over_white_noise
from ..logset import LogSet, Run
from ..machine import Array, Machine, Parameter, RunData, encoder_step, own_parameter
from .reference import derivatives
from .settings import (
    nominal_settings,
    require_controllers,
    require_units,
    run_settings,
    tolerance,
)

if TYPE_CHECKING:
    from ..effects import Form

REPEATS = 1e-4  # of the command's range, within which a repeated cycle repeats


@dataclass
class StackPlant:
    """The stack that effects act on."""

    stack: PiezoStack
    time: float = 0.0

    def change(self, **fields: Any) -> None:
        """Replace constants of the stack."""
        self.stack = self.stack._replace(**fields)

    def finished(self) -> PiezoStack:
        """The stack."""
        return self.stack


@dataclass(frozen=True, kw_only=True)
class PiezoMachine(Machine):
    """A piezo stack, predicted by simulating it from its command."""

    span: tuple[float, float]  # of the command [V]

    def build(self, values: Mapping[str, float]) -> StackPlant:
        """A linear stack at the own parameters' values."""
        stack = linear_stack(values["gain"], values["offset"], values["rest"])
        return StackPlant(stack=stack._replace(middle=0.5 * (self.span[0] + self.span[1])))

    def predict(self, run: RunData, plant: PiezoStack) -> Array:
        """Measured less simulated length (samples, 1) over the run's window [um]."""
        assert isinstance(run, StackRun)
        stop = run.window.indices(len(run.t))[1]
        length = np.empty(stop)
        piezo_stack_kernel.simulate(
            run.t[:stop], run.voltage[:stop], plant, np.array(DECADES), length
        )
        return (run.position[:stop, 0] - length)[run.window][:, None]

    def forms(self, runs: Sequence[RunData]) -> "list[Form]":
        """Hysteresis, creep, the amplifier, wrong gains and a drifting sensor."""
        from .piezo_forms import piezo_forms  # the effects' base names other machines

        return piezo_forms(self, runs)

    def out_of_step(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> float | None:
        """What does not repeat, over the sensor's white noise."""
        return over_white_noise(runs, residuals)


@dataclass(frozen=True, kw_only=True)
class StackRun(RunData):
    """A run with its voltage; ``command`` and ``reference`` are the nominal length of it [um]."""

    voltage: Array  # (samples,) [V]


def read(logset: LogSet) -> tuple[Machine, list[RunData]]:
    """Machine and runs of a piezo log set.

    A gain that is not stated is the ratio of the ranges of length and command, within half of itself,
    an offset that is not stated the mean distance from it, both of the fit runs. A command before the
    first sample that is not stated is 0 V: a run that begins in the middle of a motion must state it, or
    its first cycle is predicted with a step that never was.
    """
    require_units(logset, {"u": "V", "y": "um"})
    nominal = nominal_settings(logset, {"gain_um_per_V", "offset_um", "rest_V"})
    require_controllers(logset, "open_loop")
    u = np.concatenate([run.columns["u"] for run in logset.fit])
    y = np.concatenate([run.columns["y"] for run in logset.fit])
    if np.ptp(u) <= 0.0:
        raise InputError(logset.folder, "a command u that never changes", "a command that moves")
    relative = tolerance(logset)
    if np.ptp(y) <= 0.0:
        raise InputError(logset.folder, "a length y that never changes", "a stack that moves")
    gain = nominal.number("gain_um_per_V", float(np.ptp(y) / np.ptp(u)), positive=True)
    offset = nominal.number("offset_um", float(np.mean(y) - gain * np.mean(u)))
    rest = nominal.number("rest_V", 0.0)
    stated = logset.system.get("nominal", {})
    reach = max(float(np.ptp(y)), abs(offset))  # a zero of the sensor is arbitrary
    machine = PiezoMachine(
        kind="piezo_stack",
        joints=("stack",),
        position_unit="um",
        effort_unit="um",
        own=(
            own_parameter("gain", "um/V", gain, relative)
            if "gain_um_per_V" in stated
            else own_parameter("gain", "um/V", gain, 0.5),
            Parameter(
                name="offset", unit="um", lower=offset - reach, upper=offset + reach,
                scale=0.1 * float(np.ptp(y)), starts=(offset,),
            ),
            Parameter(
                name="rest", unit="V", lower=rest, upper=rest, scale=float(np.ptp(u)),
                starts=(rest,),
            ),
        ),
        span=(float(np.min(u)), float(np.max(u))),
    )  # fmt: skip
    return machine, [_run(run, logset, gain, offset) for run in logset.runs]


def _run(run: Run, logset: LogSet, gain: float, offset: float) -> StackRun:
    settings, dt = run_settings(logset, run), logset.dt
    voltage = np.ascontiguousarray(run.columns["u"])
    asked = (offset + gain * voltage)[:, None]
    rate, acceleration = derivatives(asked, dt)
    return StackRun(
        name=run.name,
        use=run.use,
        settings=run.settings,
        dt=dt,
        t=run.columns["t"] - run.columns["t"][0],
        reference=asked,
        reference_rate=rate,
        reference_acceleration=acceleration,
        position=run.stack("y"),
        command=asked,
        controller=None,
        period=settings.period(dt) or cycle(voltage),
        lsb=encoder_step(run.columns["y"]),
        start=settings.start,
        voltage=voltage,
    )


def cycle(command: Array) -> int | None:
    """Samples after which a command (samples,) repeats itself to the end; None if it never does."""
    size = float(np.ptp(command))
    start = int(np.argmax(np.abs(command - command[0]) > 0.25 * size))  # left its first value
    for period in range(max(start, 2), len(command) // 2 + 1):
        if abs(command[period] - command[0]) > REPEATS * size:
            continue
        if np.max(np.abs(command[period:] - command[:-period])) <= REPEATS * size:
            return period
    return None
