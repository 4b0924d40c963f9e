"""Dry friction that falls with speed before viscous friction makes it rise."""

from ....models.drive import BREAKAWAY, STRIBECK_SPEED
from ..drive_machine import DriveMachine, DrivePlant
from .base import RARE, Effect, Form, Scales, Values, at, parameter
from .dry_friction import FAMILY, apply_smooth_sign, level_parameters, width_parameter


def forms(machine: DriveMachine, scales: Scales) -> list[Form]:
    """Levels, what breakaway adds to them as a share, and the speed over which that decays."""
    levels = level_parameters(machine, scales)
    share = parameter("breakaway_share", "-", 0.5, lower=0.0, upper=5.0, starts=(0.5,))
    speed = parameter(
        "stribeck_speed",
        machine.unit("rate"),
        0.1 * scales.rate,
        lower=0.005 * scales.rate,
        upper=scales.rate,
        starts=(0.1 * scales.rate, 0.3 * scales.rate),
    )
    smooth = apply_smooth_sign(machine, scales)

    def apply(plant: DrivePlant, values: Values) -> None:
        smooth(plant, values)
        for i, e in enumerate(machine.elements):
            extra = values["breakaway_share"] * values.get(f"level_{e}", 0.0)
            plant.drive.element[i, BREAKAWAY] += extra
            plant.drive.element[i, STRIBECK_SPEED] = values["stribeck_speed"]

    return [
        Form(
            effect=EFFECT.id,
            name="Gaussian decay",
            parameters=(*levels, share, speed, width_parameter(machine, scales)),
            apply=apply,
            where=at("elements", "level_"),
            shapes=frozenset({"breakaway_share", "stribeck_speed", "width"}),
            removable=frozenset(p.name for p in levels),
            family=FAMILY,
            price=RARE,
        )
    ]


EFFECT = Effect(
    id="friction.stribeck",
    summary="dry friction that falls with speed before it rises",
    forms=forms,
    signature="unexplained torque that steps with the speed's sign and is largest at low speed",
)
