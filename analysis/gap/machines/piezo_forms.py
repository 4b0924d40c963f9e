"""What can be wrong with a piezo stack: every form changes constants of ``models/piezo_stack.py``."""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..effects.base import RARE, Form, Values, everywhere, parameter
from ..machine import Parameter, RunData
from .piezo_stack import StackPlant

if TYPE_CHECKING:
    from .piezo_stack import PiezoMachine

ELEMENTS = 4  # stops, their limits spread evenly over half the commanded span
CREEPS = frozenset({"sensor.offset"})  # what creep looks like without it
BENDS = frozenset({"actuator.torque_constant", "sensor.scale"})  # what a bent loop looks like


def piezo_forms(machine: "PiezoMachine", runs: Sequence[RunData]) -> list[Form]:
    """All forms, scaled to the runs."""
    low, high = machine.span
    half = 0.5 * (high - low)
    dt = runs[0].dt
    length = float(np.ptp(np.concatenate([r.position[r.window] for r in runs])))
    gain, gain_unit = machine.nominal()["gain"], "um/V"
    where = everywhere("joints", machine.joints)

    def form(
        effect: str,
        name: str,
        free: Sequence[Parameter],
        apply: Callable[[StackPlant, Values], None],
        **more: Any,
    ) -> Form:
        return Form(
            effect=effect, name=name, parameters=tuple(free), apply=apply, where=where, **more
        )

    slope = parameter("slope", gain_unit, abs(gain), starts=(gain,), lower=-10.0 * abs(gain),
                      upper=10.0 * abs(gain))  # fmt: skip
    shares = [
        parameter(f"share_{i}", "-", 0.1, lower=-2.0, upper=2.0, starts=(0.05,))
        for i in range(1, ELEMENTS + 1)
    ]
    bouc_wen = [
        parameter("alpha", "-", 0.2, lower=0.0, upper=2.0, starts=(0.2,)),
        parameter("beta", "1/V", 1.0 / half, lower=0.0, upper=20.0 / half, starts=(1.0 / half,)),
        parameter("gamma", "1/V", 1.0 / half, lower=-20.0 / half, upper=20.0 / half),
    ]
    curvature = parameter("curvature", "1/V", 0.05 / half, lower=-0.5 / half, upper=0.5 / half)
    creep = parameter("creep_per_decade", "-", 0.01, lower=-0.2, upper=0.2)
    limits = half * np.arange(1, ELEMENTS + 1) / (ELEMENTS + 1)

    def hysteretic(plant: StackPlant, values: Values) -> None:
        plant.change(gain=values["slope"])
        if "alpha" in values:
            plant.change(**{name: values[name] for name in ("alpha", "beta", "gamma")})
        else:
            each = [values.get(s.name, 0.0) for s in shares]
            plant.change(limits=limits, shares=np.array(each))
        if "curvature" in values:
            plant.change(curvature=values["curvature"])
        if "creep_per_decade" in values:
            plant.change(creep=values["creep_per_decade"])

    kernels: tuple[tuple[str, list[Parameter], frozenset[str]], ...] = (
        ("Maxwell slip", shares, frozenset(s.name for s in shares)),
        ("Bouc-Wen", bouc_wen, frozenset()),
    )
    extras: tuple[tuple[list[Parameter], str, frozenset[str]], ...] = (
        ([], "", frozenset()),
        ([curvature], ", bent", BENDS),
        ([creep], ", creeping", CREEPS),
        ([curvature, creep], ", bent and creeping", BENDS | CREEPS),
    )
    found = [
        form(
            "actuator.hysteresis",
            kernel + name,
            [slope, *free, *more],
            hysteretic,
            own_start=True,
            refined=bool(more),
            removable=removable,
            replaces=frozenset({"gain"}),
            stands_for=stands_for,
            price=RARE if more else 0.0,
        )
        for more, name, stands_for in extras
        for kernel, free, removable in kernels
    ]
    return [
        *found,
        form("actuator.lag", "first order", [_lag(dt)], _lagging(1)),
        form("actuator.lag", "second order", [_lag(dt)], _lagging(2)),
        form("actuator.delay", "transport delay", [_delay(dt)], _set("delay", "delay")),
        form("actuator.saturation", "clipped command", [_limit(low, high)],
             _set("high", "limit")),
        form("actuator.torque_constant", "gain", [_error("gain_error")], _gain("gain_error"),
             replaces=frozenset({"gain"})),
        form("actuator.torque_constant", "gain that changes with the command", [curvature],
             _set("curvature", "curvature")),
        form("sensor.scale", "gain", [_error("scale_error")], _scale),
        form("sensor.offset", "drifting at an even rate",
             [parameter("drift", "um/s", 1e-3 * length)], _set("drift", "drift")),
    ]  # fmt: skip


def _lag(dt: float) -> Parameter:
    starts = (0.0, dt, 5.0 * dt)
    return parameter("time_constant", "s", dt, lower=0.0, upper=200.0 * dt, starts=starts)


def _delay(dt: float) -> Parameter:
    starts = (0.0, 1.5 * dt, 5.5 * dt)
    return parameter("delay", "s", dt, lower=0.0, upper=50.0 * dt, starts=starts)


def _limit(low: float, high: float) -> Parameter:
    span = high - low
    starts = tuple(high - share * span for share in (0.001, 0.1, 0.3))
    return parameter("limit", "V", span, lower=low + 0.1 * span, upper=high, starts=starts)


def _error(name: str) -> Parameter:
    return parameter(name, "-", 0.2, lower=-0.9, upper=9.0)


def _set(field: str, name: str) -> Callable[[StackPlant, Values], None]:
    return lambda plant, values: plant.change(**{field: values[name]})


def _gain(name: str) -> Callable[[StackPlant, Values], None]:
    return lambda plant, values: plant.change(gain=plant.stack.gain * (1.0 + values[name]))


def _scale(plant: StackPlant, values: Values) -> None:
    scale = 1.0 + values["scale_error"]
    plant.change(gain=plant.stack.gain * scale, offset=plant.stack.offset * scale)


def _lagging(stages: int) -> Callable[[StackPlant, Values], None]:
    return lambda plant, values: plant.change(lag=values["time_constant"], stages=stages)
