"""The effects that can act on any machine of rigid bodies, joint by joint.

Every function returns the forms of one effect of the catalogue. What depends on how the machine's
mass is described (payload, tilt of the base) comes from the module of the machine. Not here, for the
acceleration equation of one encoder per joint cannot tell them: clearance, flexibility, ripple.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...models import joint as law
from .effects.base import DRY_FRICTION, RARE, Form, Values, at, everywhere, parameter
from .effects.dry_friction import FAMILY
from .machine import Array, Parameter, RunData
from .rigid_machine import RigidMachine, RigidPlant, RigidRun

SIGN_WIDTH = 0.02  # of the smoothed sign of the nominal dry friction, as a share of the rms speed
WIDTHS = (
    0.005,
    0.2,
)  # that dry friction found in the data may have: steeper ones ask for short steps
LARGEST_DELAY = 20.0  # samples


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Typical sizes of every joint in some runs."""

    effort: Array  # (n,) rms of what the nominal motion takes
    rate: Array  # (n,) rms
    travel: Array  # (n,) range
    command: float  # rms
    peak: float  # largest command
    dt: float  # [s]


def sizes(machine: RigidMachine, runs: Sequence[RunData]) -> Sizes:
    """Typical sizes of the runs' windows on the nominal model."""
    phi = machine.build(machine.nominal()).phi
    efforts, rates, positions, commands = [], [], [], []
    for run in runs:
        assert isinstance(run, RigidRun)
        acceleration = np.gradient(run.rate, run.dt, axis=0)
        effort = np.einsum("skij,k,sj->si", run.equation.mass, phi, acceleration)
        efforts.append((effort + np.einsum("ski,k->si", run.equation.bias, phi))[run.window])
        rates.append(run.rate[run.window])
        positions.append(run.smooth[run.window])
        commands.append(run.command[run.window])
    command = np.concatenate(commands)
    return Sizes(
        effort=_rms(np.concatenate(efforts)),
        rate=np.maximum(_rms(np.concatenate(rates)), 1e-9),
        travel=np.ptp(np.concatenate(positions), axis=0),
        command=float(np.sqrt(np.mean(command**2))),
        peak=float(np.max(np.abs(command))),
        dt=runs[0].dt,
    )


def _rms(values: Array) -> Array:
    return np.asarray(np.sqrt(np.mean(values**2, axis=0)))


def joint_forms(machine: RigidMachine, runs: Sequence[RunData]) -> list[Form]:
    """Forms of every effect that acts at joints, actuators and sensors."""
    s = sizes(machine, runs)
    makers = (viscous, coulomb, stribeck, load_dependent, bias, torque_constant, delay, lag)
    return [form for make in (*makers, saturation, sensor) for form in make(machine, s)]


def per_joint(
    effect: str,
    name: str,
    prefix: str,
    parameters: Sequence[Parameter],
    apply: Callable[[RigidPlant, Values], None],
    **more: Any,
) -> Form:
    """A form with one removable parameter a joint and perhaps others that shape it."""
    return Form(
        effect=effect,
        name=name,
        parameters=tuple(parameters),
        apply=apply,
        where=at("joints", prefix),
        removable=frozenset(p.name for p in parameters if p.name.startswith(prefix)),
        **more,
    )


def _adder(machine: RigidMachine, prefix: str, column: int) -> Callable[[RigidPlant, Values], None]:
    def apply(plant: RigidPlant, values: Values) -> None:
        for j, name in enumerate(machine.joints):
            plant.joints.law[j, column] += values.get(prefix + name, 0.0)

    return apply


def _each(
    machine: RigidMachine, prefix: str, unit: str, scale: Array, lower: float = -np.inf
) -> list[Parameter]:
    return [
        parameter(prefix + name, unit, float(size), lower=lower)
        for name, size in zip(machine.joints, scale)
    ]


def viscous(machine: RigidMachine, s: Sizes) -> list[Form]:
    """More or less friction in proportion to the joint's speed."""
    unit = f"{machine.effort_unit} s/{machine.position_unit}"
    nominal = machine.nominal()
    # Friction takes energy: a coefficient may take back the nominal one, and no more.
    free = [
        parameter(
            f"coefficient_{j}",
            unit,
            float(size),
            lower=-nominal.get(machine.damping.get(j, ""), 0.0),
        )
        for j, size in zip(machine.joints, s.effort / s.rate)
    ]
    own = {f"coefficient_{joint}": name for joint, name in machine.damping.items()}
    apply = _adder(machine, "coefficient_", law.VISCOUS)
    return [
        per_joint(
            "friction.viscous", "proportional to speed", "coefficient_", free, apply, takes=own
        )
    ]


def _levels(machine: RigidMachine, s: Sizes) -> list[Parameter]:
    return _each(machine, "level_", machine.effort_unit, s.effort, lower=0.0)


def _width() -> Parameter:
    """Share of each joint's rms speed over which the smoothed sign changes."""
    low, high = WIDTHS
    return parameter("width_share", "-", SIGN_WIDTH, lower=low, upper=high, starts=(SIGN_WIDTH,))


def _dry(machine: RigidMachine, s: Sizes) -> Callable[[RigidPlant, Values], None]:
    """Levels with a smoothed sign of the given width."""
    levels = _adder(machine, "level_", law.DRY)

    def apply(plant: RigidPlant, values: Values) -> None:
        levels(plant, values)
        plant.joints.law[:, law.WIDTH] = values["width_share"] * s.rate

    return apply


def coulomb(machine: RigidMachine, s: Sizes) -> list[Form]:
    """A level for each joint, with a smoothed sign."""
    return [
        per_joint(
            "friction.coulomb",
            "smoothed sign",
            "level_",
            [*_levels(machine, s), _width()],
            _dry(machine, s),
            shapes=frozenset({"width_share"}),
            family=FAMILY,
        )
    ]


def stribeck(machine: RigidMachine, s: Sizes) -> list[Form]:
    """Levels, what standstill adds to them as a share, and the share of the rms speed it decays over."""
    share = parameter("breakaway_share", "-", 0.5, lower=0.0, upper=5.0, starts=(0.5,))
    speed = parameter(
        "stribeck_speed_share", "-", 0.2, lower=0.03, upper=2.0, starts=(0.2, 0.6)
    )  # of each joint's rms speed
    dry = _dry(machine, s)

    def apply(plant: RigidPlant, values: Values) -> None:
        dry(plant, values)
        for j, name in enumerate(machine.joints):
            extra = values["breakaway_share"] * values.get(f"level_{name}", 0.0)
            plant.joints.law[j, law.BREAKAWAY] += extra
            plant.joints.law[j, law.STRIBECK_SPEED] = values["stribeck_speed_share"] * s.rate[j]

    return [
        per_joint(
            "friction.stribeck",
            "Gaussian decay",
            "level_",
            [*_levels(machine, s), share, speed, _width()],
            apply,
            shapes=frozenset({"breakaway_share", "stribeck_speed_share", "width_share"}),
            contains=DRY_FRICTION,
            family=FAMILY,
            price=RARE,
        )
    ]


def load_dependent(machine: RigidMachine, s: Sizes) -> list[Form]:
    """A share of the motor's effort, or of the load of gravity, that is lost to friction."""
    shares = _each(machine, "share_", "-", 0.1 * np.ones(len(machine.joints)), lower=0.0)
    kinds = (
        ("share of the motor's effort", law.BY_MOTOR),
        ("share of the gravity load", law.BY_LOAD),
    )
    return [
        per_joint(
            "friction.load_dependent", name, "share_", shares, _adder(machine, "share_", column)
        )
        for name, column in kinds
    ]


def bias(machine: RigidMachine, s: Sizes) -> list[Form]:
    """A constant load on each joint, or a spring such as a cable's."""
    constant = _each(machine, "bias_", machine.effort_unit, s.effort)
    unit = f"{machine.effort_unit}/{machine.position_unit}"
    springs = _each(machine, "stiffness_", unit, s.effort / np.maximum(s.travel, 1e-9))
    return [
        per_joint("load.bias", "constant", "bias_", constant, _adder(machine, "bias_", law.BIAS)),
        per_joint(
            "load.bias", "spring and constant", "stiffness_", [*springs, *constant],
            _both(_adder(machine, "bias_", law.BIAS), _adder(machine, "stiffness_", law.SPRING)),
            own_start=True, price=RARE,
        ),
    ]  # fmt: skip


def _both(
    first: Callable[[RigidPlant, Values], None], second: Callable[[RigidPlant, Values], None]
) -> Callable[[RigidPlant, Values], None]:
    def apply(plant: RigidPlant, values: Values) -> None:
        first(plant, values)
        second(plant, values)

    return apply


def torque_constant(machine: RigidMachine, s: Sizes) -> list[Form]:
    """A gain error of each actuator."""
    free = [
        parameter(f"gain_error_{name}", "-", 0.2, lower=-0.9, upper=3.0)
        for name in machine.actuated
    ]

    def apply(plant: RigidPlant, values: Values) -> None:
        for j, name in enumerate(machine.actuated):
            plant.joints.actuator[j, law.GAIN] *= 1.0 + values.get(f"gain_error_{name}", 0.0)

    return [per_joint("actuator.torque_constant", "gain error", "gain_error_", free, apply)]


def delay(machine: RigidMachine, s: Sizes) -> list[Form]:
    """The same delay in every command."""
    return [
        _shared(
            machine, "actuator.delay", "transport delay", "delay", law.DELAY,
            parameter("delay", "s", s.dt, lower=0.0, upper=LARGEST_DELAY * s.dt,
                      starts=(0.0, s.dt, 4.0 * s.dt)),
        )
    ]  # fmt: skip


def lag(machine: RigidMachine, s: Sizes) -> list[Form]:
    """The same first-order lag in every actuator."""
    return [
        _shared(
            machine, "actuator.lag", "first order", "time_constant", law.LAG,
            parameter("time_constant", "s", s.dt, lower=0.0, upper=50.0 * s.dt,
                      starts=(0.0, s.dt, 4.0 * s.dt)),
        )
    ]  # fmt: skip


def saturation(machine: RigidMachine, s: Sizes) -> list[Form]:
    """One limit for all actuators; without gradient until it bites, it starts inside the data."""
    starts = tuple(share * s.peak for share in (0.999, 0.9, 0.75, 0.55, 0.35))
    limit = parameter(
        "limit", machine.command_unit, s.peak, lower=0.05 * s.peak, upper=s.peak, starts=starts
    )
    return [_shared(machine, "actuator.saturation", "clipped command", "limit", law.LIMIT, limit)]


def _shared(
    machine: RigidMachine, effect: str, form: str, name: str, column: int, free: Parameter
) -> Form:
    def apply(plant: RigidPlant, values: Values) -> None:
        plant.joints.actuator[:, column] = values[name]

    return Form(
        effect=effect,
        name=form,
        parameters=(free,),
        apply=apply,
        where=everywhere("joints", machine.actuated),
    )


def sensor(machine: RigidMachine, s: Sizes) -> list[Form]:
    """An offset, or a scale error, of each encoder."""
    offsets = _each(machine, "offset_", machine.position_unit, 0.05 * np.maximum(s.travel, 1e-6))
    scales = [
        parameter(f"scale_error_{name}", "-", 0.05, lower=-0.5, upper=1.0)
        for name in machine.joints
    ]

    def shift(plant: RigidPlant, values: Values) -> None:
        for j, name in enumerate(machine.joints):
            plant.offset[j] += values.get(f"offset_{name}", 0.0)

    def stretch(plant: RigidPlant, values: Values) -> None:
        for j, name in enumerate(machine.joints):
            plant.scale[j] *= 1.0 + values.get(f"scale_error_{name}", 0.0)

    return [
        per_joint("sensor.offset", "wrong zero", "offset_", offsets, shift),
        per_joint("sensor.scale", "scale error", "scale_error_", scales, stretch),
    ]
