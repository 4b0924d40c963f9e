"""Dry friction that falls with speed before viscous friction makes it rise."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ....models import friction
from ....models.drive import BREAKAWAY, STRIBECK_EXPONENT, STRIBECK_SPEED
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

# A fitted law that falls by less than this share of its level only rounds the corner of dry friction.
LEAST_FALL = 0.05
# So does one that has fallen at speeds below this multiple of the least that the search allows.
RESOLVED = 1.05


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """Levels, what breakaway adds to them as a share, and the speed over which that decays, in two shapes.

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

    def form(
        name: str,
        shape: Parameter,
        law: Callable[[ShaftPlant, Values], None],
        falls: Callable[[Values], float],
        exponent: float = 2.0,
    ) -> Form:
        def apply(plant: ShaftPlant, values: Values) -> None:
            law(plant, values)
            for i, e in enumerate(machine.elements):
                extra = values["breakaway_share"] * values.get(f"level_{e}", 0.0)
                plant.drive.element[i, BREAKAWAY] += extra
                plant.drive.element[i, STRIBECK_SPEED] = values["stribeck_speed"]
                plant.drive.element[i, STRIBECK_EXPONENT] = exponent

        falling = Form(
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
        rounded = _corner_of_its_own(falling)

        def amounts_to(values: Values) -> Form | None:
            resolved = values["stribeck_speed"] > RESOLVED * speed.lower
            return None if resolved and falls(values) > LEAST_FALL else rounded

        return replace(falling, amounts_to=amounts_to)

    width, travel = width_parameter(machine, scales), travel_parameter(machine, scales)
    smooth = apply_smooth_sign(machine, scales)
    return [
        form("Gaussian decay", width, smooth, fall),
        form("exponential decay", width, smooth, lambda values: fall(values, 1.0), 1.0),
        form(
            "LuGre",
            travel,
            apply_bristles(machine, scales),
            lambda values: values["breakaway_share"],
        ),
    ]


def fall(values: Values, exponent: float = 2.0) -> float:
    """How far the smoothed law (4) of ``friction`` falls from its peak to its sliding level, as a share of that."""
    width, decay = values["width"], values["stribeck_speed"]
    speed = np.linspace(0.0, 5.0 * max(width, decay), 2001)
    law = friction.dry(speed, 1.0, 1.0, values["breakaway_share"], decay, width, exponent)
    return float(max(law.max() - 1.0, 0.0))


def _corner_of_its_own(falling: Form) -> Form:
    """The same law as a form of dry friction: where it does not fall, it shapes the corner at standstill."""
    (effect,) = DRY_FRICTION
    names = {"breakaway_share": "corner_share", "stribeck_speed": "corner_speed"}

    def apply(plant: ShaftPlant, values: Values) -> None:
        falling.apply(plant, {**values, **{old: values[new] for old, new in names.items()}})

    return replace(
        falling,
        effect=effect,
        name="corner of its own shape",
        parameters=tuple(replace(p, name=names.get(p.name, p.name)) for p in falling.parameters),
        apply=apply,
        shapes=frozenset(names.get(name, name) for name in falling.shapes),
        contains=frozenset(),
    )


EFFECT = Effect(
    id="friction.stribeck",
    summary="dry friction that falls with speed before it rises",
    forms=forms,
    signature="unexplained torque that steps with the speed's sign and is largest at low speed",
)
