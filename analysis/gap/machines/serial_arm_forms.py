"""What can be wrong with an arm of position servos: forms change constants of ``models/position_servo.py``.

A position log alone does not tell a load from a false zero of the encoder, nor dry friction inside the
servo's loop from a clearance behind it. Where the torque is logged and follows the logged error at rest, the
loop acts on what is logged, and nothing behind the loop can have made that error: offset, scale
and clearance are then left out (``servo_torque.py``).
"""

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ..effects.base import Form, Values, at, everywhere, parameter
from ..machine import Parameter
from .serial_arm import INERTIA, TIME_CONSTANT, ArmPlant, ArmRun
from .servo_torque import loop_acts_on_log

if TYPE_CHECKING:
    from .serial_arm import ArmMachine

SAG = 0.03  # typical error that a load or dry friction makes [rad]
Apply = Callable[[ArmPlant, Values], None]


def arm_forms(machine: "ArmMachine", runs: Sequence[ArmRun]) -> list[Form]:
    """All forms, scaled to the runs."""
    found = [*_loads(machine), *_friction(machine), *_servos(machine, runs)]
    return found if loop_acts_on_log(runs) else found + _behind_the_loop(machine)


def _each(
    machine: "ArmMachine", name: str, unit: str, scale: float, **more: Any
) -> list[Parameter]:
    return [parameter(f"{name}_{joint}", unit, scale, **more) for joint in machine.joints]


def _per_joint(machine: "ArmMachine", name: str, field: str) -> Apply:
    """Every joint's constant ``field`` takes the value of its parameter."""

    def apply(plant: ArmPlant, values: Values) -> None:
        for j, joint in enumerate(machine.joints):
            plant.change(j, **{field: values.get(f"{name}_{joint}", 0.0)})

    return apply


def _form(
    machine: "ArmMachine", effect: str, name: str, prefix: str, free: Sequence[Parameter],
    apply: Apply, **more: Any,
) -> Form:  # fmt: skip
    """A form with one parameter a joint, named ``prefix_JOINT``, any of which may go."""
    of_joints = frozenset(p.name for p in free if p.name.startswith(f"{prefix}_"))
    return Form(
        effect=effect, name=name, parameters=tuple(free), apply=apply,
        where=at("joints", f"{prefix}_"), removable=of_joints, **more,
    )  # fmt: skip


def _loads(machine: "ArmMachine") -> list[Form]:
    biases = _each(machine, "bias", "rad", SAG)

    def constant(plant: ArmPlant, values: Values) -> None:
        plant.bias += [values.get(p.name, 0.0) for p in biases]

    found = [_form(machine, "load.bias", "constant", "bias", biases, constant)]
    return [*found, _gravity(machine, biases, constant)] if machine.chain else found


def _gravity(machine: "ArmMachine", biases: Sequence[Parameter], constant: Apply) -> Form:
    """Gravity of links that turn about parallel axes, and a constant load at all joints.

    Link k turns by the sum A_k of the angles up to its joint; its weight loads every joint of the chain
    up to there by the same c_k cos A_k + s_k sin A_k.
    """
    links = [machine.joints[j] for j, _ in machine.chain]
    weights = [parameter(f"{f}_{link}", "rad", SAG) for link in links for f in ("cos", "sin")]

    def apply(plant: ArmPlant, values: Values) -> None:
        constant(plant, values)
        for k, link in enumerate(links):
            for j, sign in machine.chain[: k + 1]:
                plant.turning[j, k] += [
                    sign * values.get(f"{f}_{link}", 0.0) for f in ("cos", "sin")
                ]

    def where(names: Sequence[str]) -> dict[str, Any]:
        turning = [k for k, n in enumerate(links) if {f"cos_{n}", f"sin_{n}"} & set(names)]
        loaded = set(links[: max(turning) + 1]) if turning else set()
        loaded |= {name.removeprefix("bias_") for name in names if name.startswith("bias_")}
        return {"joints": [joint for joint in machine.joints if joint in loaded]}

    free = (*weights, *biases)
    return Form(
        effect="load.bias", name="gravity of the links", parameters=free, apply=apply, where=where,
        removable=frozenset(p.name for p in free),
    )  # fmt: skip


def _friction(machine: "ArmMachine") -> list[Form]:
    levels = _each(machine, "level", "rad", SAG, lower=0.0, starts=(0.0, SAG))
    share = parameter("share", "-", 0.3, lower=0.0, upper=3.0, starts=(0.0, 0.3))
    upper = 20.0 * TIME_CONSTANT
    damping = _each(
        machine, "damping", "s", TIME_CONSTANT, lower=0.0, upper=upper, starts=(TIME_CONSTANT,)
    )

    return [
        _form(machine, "friction.coulomb", "level", "level", levels, _per_joint(machine, "level", "level")),
        Form(effect="friction.load_dependent", name="share of the load", parameters=(share,),
             apply=lambda plant, values: plant.change_all(share=values["share"]),
             where=everywhere("joints", machine.joints)),
        Form(effect="friction.viscous", name="proportional to speed", parameters=tuple(damping),
             apply=_per_joint(machine, "damping", "damping"),
             where=everywhere("joints", machine.joints),
             replaces=frozenset(f"time_constant_{j}" for j in machine.joints)),
    ]  # fmt: skip


def _servos(machine: "ArmMachine", runs: Sequence[ArmRun]) -> list[Form]:
    dt = runs[0].fine_dt
    fastest = max(float(np.max(np.abs(run.reference_rate))) for run in runs) or 1.0
    errors = [np.abs(run.fine_position - run.fine_reference) for run in runs]
    largest = max(float(np.max(e)) for e in errors) or 1.0
    where = everywhere("joints", machine.joints)
    delay = parameter("delay", "s", dt, lower=0.0, upper=20.0 * dt, starts=(dt, 4.0 * dt))
    lag = parameter("time_constant", "s", dt, lower=0.0, upper=20.0 * dt, starts=(0.0, 3.0 * dt))
    speed = parameter("speed_limit", "rad/s", fastest, lower=0.02 * fastest, upper=fastest,
                      starts=(fastest, 0.8 * fastest, 0.5 * fastest, 0.25 * fastest))  # fmt: skip
    error = parameter("error_limit", "rad", largest, lower=0.05 * largest, upper=largest,
                      starts=(largest, 0.7 * largest, 0.4 * largest))  # fmt: skip
    inertia = _each(machine, "inertia", "s^2", INERTIA, lower=0.0, upper=20.0 * INERTIA,
                    starts=(INERTIA,))  # fmt: skip

    def all_joints(field: str, name: str) -> Apply:
        return lambda plant, values: plant.change_all(**{field: values[name]})

    def form(effect: str, name: str, free: Parameter, field: str, **more: Any) -> Form:
        return Form(effect=effect, name=name, parameters=(free,), where=where,
                    apply=all_joints(field, free.name), **more)  # fmt: skip

    return [
        form("actuator.delay", "transport delay", delay, "delay", replaces=frozenset({"delay"})),
        form("actuator.lag", "first order", lag, "lag"),
        form("actuator.saturation", "speed limit", speed, "speed_limit"),
        form("actuator.saturation", "torque limit", error, "error_limit"),
        Form(effect="inertia.payload", name="inertia by joint", parameters=tuple(inertia),
             apply=_per_joint(machine, "inertia", "inertia"), where=where,
             replaces=frozenset({"inertia"})),
    ]  # fmt: skip


def _behind_the_loop(machine: "ArmMachine") -> list[Form]:
    gaps = _each(machine, "gap", "rad", SAG, lower=0.0, starts=(0.0, 2.0 * SAG))
    zeros = _each(machine, "zero", "rad", SAG)
    scales = _each(machine, "scale_error", "-", SAG, lower=-0.9, upper=9.0)
    return [
        _form(machine, "transmission.backlash", "play behind the servo", "gap", gaps,
              _per_joint(machine, "gap", "gap")),
        _form(machine, "sensor.offset", "zero of the encoder", "zero", zeros,
              _per_joint(machine, "zero", "zero")),
        _form(machine, "sensor.scale", "gain of the encoder", "scale_error", scales,
              _per_joint(machine, "scale_error", "scale_error")),
    ]  # fmt: skip
