"""Clearance between motor and load: a dead zone that opens when the transmitted force changes sign."""

import numpy as np

from ..drive_machine import DriveMachine, DrivePlant
from .base import Effect, Form, Scales, Values, everywhere, parameter
from .two_inertia import CONTACT, FAMILY, ON_LOAD, motor_share_parameter, split


def forms(machine: DriveMachine, scales: Scales) -> list[Form]:
    """The same clearance at every shaft or at one of them; contact is stiff and dissipates.

    Where the encoders may sit behind it, at every shaft that way, too.
    """
    unit = 5e-4 * scales.travel
    gap = parameter(
        "gap",
        machine.unit("position"),
        unit,
        lower=0.0,
        upper=200.0 * unit,
        starts=tuple(unit * np.geomspace(0.07, 3.0, 9)),
    )
    share = motor_share_parameter(machine)
    damping = parameter("contact_damping_ratio", "-", 0.5, lower=0.02, upper=3.0, starts=(1.0,))
    friction = parameter("load_friction", "-", 0.3, lower=0.0, upper=1.0, starts=(0.0, 1.0))
    stiffness = CONTACT * scales.effort_peak / scales.travel

    def form(name: str, loose: tuple[str, ...], load_encoders: bool = False) -> Form:
        here = np.array([float(s in loose) for s in machine.joints])

        def apply(plant: DrivePlant, values: Values) -> None:
            split(
                plant,
                machine,
                share=values["motor_share"],
                stiffness=stiffness,
                damping_ratio=values["contact_damping_ratio"],
                gap=values["gap"] * here,
                dt=scales.dt,
                load_friction=values["load_friction"],
                load_encoders=load_encoders,
            )

        return Form(
            effect=EFFECT.id,
            name=name,
            parameters=(gap, share, damping, friction),
            apply=apply,
            where=everywhere("joints", loose),
            step=0.02,
            family=FAMILY,
            own_start=True,
        )

    name, single = "dead zone, stiff contact", machine.joints if len(machine.joints) > 1 else ()
    found = [form(name, machine.joints), *(form(f"{name}, {s} only", (s,)) for s in single)]
    if machine.load_encoders:
        found.append(form(name + ON_LOAD, machine.joints, load_encoders=True))
    return found


EFFECT = Effect(
    id="transmission.backlash",
    summary="clearance, dead zone on reversal",
    forms=forms,
    signature="short bursts of unexplained torque after the torque changes sign",
)
