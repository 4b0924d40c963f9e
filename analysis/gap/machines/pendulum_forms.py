"""What can be wrong with a servo pendulum: every form changes constants of ``servo_pendulum.py``."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..effects.base import DRY_FRICTION, RARE, Form, Values, everywhere, parameter
from ..machine import Parameter, RunData
from .pendulum import RESISTANCE, TORQUE_CONSTANT, ServoPlant, ServoRun

DRY = "dry friction"
Apply = Callable[[ServoPlant, Values], None]


def pendulum_forms(joints: tuple[str, ...], runs: Sequence[RunData]) -> list[Form]:
    """All forms, scaled to the runs."""
    where = everywhere("joints", joints)

    def form(effect: str, name: str, free: Sequence[Parameter], apply: Apply, **more: Any) -> Form:
        return Form(
            effect=effect, name=name, parameters=tuple(free), apply=apply, where=where, **more
        )

    return [
        form("friction.viscous", "linear", [_VISCOUS], _set("viscous")),
        form("friction.coulomb", "level", [_LEVEL], _dry, family=DRY),
        form("friction.coulomb", "level, by direction", [_LEVEL, _ASYMMETRY], _dry, family=DRY,
             refined=True, removable=frozenset({"level", "asymmetry"}), price=RARE),
        form("friction.stribeck", "Gaussian decay", [_LEVEL, _BREAKAWAY, _SPEED], _dry,
             family=DRY, shapes=frozenset({"stribeck_speed"}), contains=DRY_FRICTION, price=RARE),
        form("friction.load_dependent", "share of the gear's load", [_SHARE], _lost),
        form("friction.load_dependent", "shares of motor and load", [_MOTOR, _LOAD], _lost,
             removable=frozenset({"share_motor", "share_load"})),
        form("friction.load_dependent", "growing shares of motor and load",
             [_MOTOR, _LOAD, _GROWTH], _lost, shapes=frozenset({"growth"}),
             removable=frozenset({"share_motor", "share_load", "growth"})),
        form("friction.load_dependent", "growing shares of motor and load, larger at rest",
             [_MOTOR, _LOAD, _GROWTH, _AT_REST, _SPEED], _lost, refined=True,
             shapes=frozenset({"growth", "rest_share", "stribeck_speed"}),
             removable=frozenset({"share_motor", "share_load", "growth", "rest_share"}),
             stands_for=frozenset({"friction.coulomb", "friction.stribeck"})),
        form("actuator.torque_constant", "other constant", [_CONSTANT, _RESISTANCE], _motor,
             replaces=frozenset({"torque_constant", "resistance"})),
        form("actuator.torque_constant", "falling with the current", [_DROOP], _set("droop")),
        *_command_path(form, runs),
        # All torques grow with the mass: with the resistance free as well, nothing would set their scale.
        form("inertia.payload", "added mass", [_MASS], _payload,
             replaces=frozenset({"resistance"})),
        form("inertia.payload", "added inertia", [_INERTIA], _payload,
             replaces=frozenset({"rotor_inertia"})),
        form("load.bias", "constant", [_BIAS], _set("bias")),
        form("sensor.offset", "zero of the encoder", [_ZERO], _set("zero")),
    ]  # fmt: skip


def _command_path(form: Callable[..., Form], runs: Sequence[RunData]) -> list[Form]:
    dt = runs[0].dt
    peak = max(float(np.max(np.abs(r.voltage))) for r in runs if isinstance(r, ServoRun))
    most = max(peak, 1e-3) / RESISTANCE  # current at standstill [A]
    delay = parameter(
        "delay", "s", dt, lower=0.0, upper=10.0 * dt, starts=(0.0, 1.5 * dt, 3.5 * dt)
    )
    lag = parameter(
        "time_constant", "s", dt, lower=0.0, upper=20.0 * dt, starts=(0.0, dt, 4.0 * dt)
    )
    limit = parameter(
        "current_limit", "A", most, lower=0.05 * most, upper=1.5 * most,
        starts=(most, 0.8 * most, 0.6 * most, 0.4 * most),
    )  # fmt: skip
    return [
        form("actuator.delay", "transport delay", [delay], _set("delay")),
        form("actuator.lag", "first order", [lag], _set("lag", "time_constant")),
        form("actuator.saturation", "current limit", [limit], _set("limit", "current_limit")),
    ]


_VISCOUS = parameter("viscous", "N m s/rad", 0.005, lower=0.0)
_LEVEL = parameter("level", "N m", 0.05, lower=0.0, starts=(0.0, 0.05))
_ASYMMETRY = parameter("asymmetry", "-", 0.3, lower=-1.0, upper=1.0)
_BREAKAWAY = parameter("breakaway_share", "-", 0.5, lower=0.0, upper=10.0, starts=(0.5,))
_SPEED = parameter(
    "stribeck_speed", "rad/s", 0.5, lower=0.05, upper=5.0, starts=(0.5, 0.15, 1.5)
)  # fmt: skip
_SHARE = parameter("share", "-", 0.1, lower=0.0, upper=0.9, starts=(0.0, 0.2))
_MOTOR = parameter("share_motor", "-", 0.1, lower=0.0, upper=0.9, starts=(0.0, 0.2))
_LOAD = parameter("share_load", "-", 0.1, lower=0.0, upper=0.9, starts=(0.0, 0.2))
_GROWTH = parameter("growth", "1/(N m)", 1.0, lower=0.0, upper=20.0, starts=(0.0, 1.0))
_AT_REST = parameter("rest_share", "-", 0.3, lower=0.0, upper=10.0, starts=(0.0, 0.3))
_CONSTANT = parameter(
    "torque_constant", "N m/A", 0.3, lower=0.05, upper=1.5, starts=(TORQUE_CONSTANT,)
)
_RESISTANCE = parameter("resistance", "ohm", 3.0, lower=0.5, upper=20.0, starts=(RESISTANCE,))
_DROOP = parameter("droop", "1/A", 0.1, lower=0.0, upper=0.4)
_MASS = parameter("extra_mass", "kg", 0.1, lower=-0.4)
_INERTIA = parameter("extra_inertia", "kg m^2", 1e-3, lower=-1.5e-3)
_BIAS = parameter("bias", "N m", 0.05)
_ZERO = parameter("zero", "rad", 0.02, lower=-0.5, upper=0.5)


def _set(field: str, name: str = "") -> Apply:
    """The servo's constant ``field`` takes the value of the parameter ``name``."""
    return lambda plant, values: plant.change(**{field: values[name or field]})


def _dry(plant: ServoPlant, values: Values) -> None:
    level, asymmetry = values.get("level", 0.0), values.get("asymmetry", 0.0)
    plant.change(forward=level * (1.0 + asymmetry), backward=level * (1.0 - asymmetry))
    if "breakaway_share" in values:
        plant.change(
            breakaway=values["breakaway_share"] * level, stribeck_speed=values["stribeck_speed"]
        )


def _lost(plant: ServoPlant, values: Values) -> None:
    common = values.get("share", 0.0)
    plant.change(
        motor_share=values.get("share_motor", common),
        load_share=values.get("share_load", common),
        growth=values.get("growth", 0.0),
        rest_share=values.get("rest_share", 0.0),
    )
    if "stribeck_speed" in values:
        plant.change(stribeck_speed=values["stribeck_speed"])


def _motor(plant: ServoPlant, values: Values) -> None:
    plant.change(torque_constant=values["torque_constant"], resistance=values["resistance"])


def _payload(plant: ServoPlant, values: Values) -> None:
    plant.mass += values.get("extra_mass", 0.0)
    plant.rotor += values.get("extra_inertia", 0.0)
