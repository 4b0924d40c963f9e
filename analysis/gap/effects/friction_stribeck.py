"""Dry friction that falls with speed before viscous friction makes it rise."""

from collections.abc import Callable

from ....models.drive import BREAKAWAY, STRIBECK_SPEED
from ..machine import Parameter
from .base import (
    DRY_FRICTION,
    RARE,
    Effect,
    Form,
    Scales,
    ShaftMachine,
    ShaftPlant,
    Values,
    at,
    parameter,
)
from .dry_friction import (
    FAMILY,
    apply_bristles,
    apply_smooth_sign,
    level_parameters,
    travel_parameter,
    width_parameter,
)


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """Levels, what breakaway adds to them as a share, and the speed over which that decays.

    With a smoothed sign or, where that is the best explanation, with bristles of a short travel (LuGre).
    """
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

    def form(name: str, shape: Parameter, law: Callable[[ShaftPlant, Values], None]) -> Form:
        def apply(plant: ShaftPlant, values: Values) -> None:
            law(plant, values)
            for i, e in enumerate(machine.elements):
                extra = values["breakaway_share"] * values.get(f"level_{e}", 0.0)
                plant.drive.element[i, BREAKAWAY] += extra
                plant.drive.element[i, STRIBECK_SPEED] = values["stribeck_speed"]

        return Form(
            effect=EFFECT.id,
            name=name,
            parameters=(*levels, share, speed, shape),
            apply=apply,
            where=at("elements", "level_"),
            shapes=frozenset({"breakaway_share", "stribeck_speed", shape.name}),
            removable=frozenset(p.name for p in levels),
            family=FAMILY,
            contains=DRY_FRICTION,
            price=RARE,
            refined=shape.name == "travel",
        )

    width, travel = width_parameter(machine, scales), travel_parameter(machine, scales)
    return [
        form("Gaussian decay", width, apply_smooth_sign(machine, scales)),
        form("LuGre", travel, apply_bristles(machine, scales)),
    ]


EFFECT = Effect(
    id="friction.stribeck",
    summary="dry friction that falls with speed before it rises",
    forms=forms,
    signature="unexplained torque that steps with the speed's sign and is largest at low speed",
)
