"""A flexible coupling, belt, screw or link between motor and load."""

from ..drive_machine import DriveMachine, DrivePlant
from .base import Effect, Form, Scales, Values, everywhere, parameter
from .two_inertia import CONTACT, FAMILY, ON_LOAD, motor_share_parameter, split

RIGID = 1.5  # times the stiffest spring of the search: no flexibility that these steps resolve


def forms(machine: DriveMachine, scales: Scales) -> list[Form]:
    """The same flexibility at every shaft, with the motor's share of the inertia; encoders before it or behind it."""
    stiffest = scales.travel / (CONTACT * scales.effort_peak)
    compliance = parameter(
        "compliance",
        f"{machine.position_unit}/({machine.effort_unit})",
        30.0 * stiffest,
        lower=stiffest,
        upper=1e5 * stiffest,
        starts=(2.0 * stiffest, 10.0 * stiffest, 100.0 * stiffest, 1000.0 * stiffest),
    )
    share = motor_share_parameter(machine)
    damping = parameter("damping_ratio", "-", 0.1, lower=0.0, upper=1.0, starts=(0.05, 0.3))

    def form(name: str, load_encoders: bool) -> Form:
        def apply(plant: DrivePlant, values: Values) -> None:
            split(
                plant,
                machine,
                share=values["motor_share"],
                stiffness=1.0 / values["compliance"],
                damping_ratio=values["damping_ratio"],
                gap=0.0,
                dt=scales.dt,
                load_encoders=load_encoders,
            )

        return Form(
            effect=EFFECT.id,
            name=name,
            parameters=(compliance, share, damping),
            apply=apply,
            where=everywhere("joints", machine.joints),
            family=FAMILY,
            least={"compliance": RIGID * stiffest},
        )

    found = [form("two inertias", False)]
    if machine.load_encoders:
        found.append(form("two inertias" + ON_LOAD, True))
    return found


EFFECT = Effect(
    id="transmission.compliance",
    summary="flexible coupling, belt, screw, gear or link",
    forms=forms,
    signature="unexplained torque that rings at one frequency after each change of the command",
)
