"""Elastic, hysteretic displacement before sliding, long enough for the encoder to see it."""

from .base import RARE, Effect, Form, Scales, ShaftMachine, at, parameter
from .dry_friction import FAMILY, apply_bristles, level_parameters


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """Dahl's bristles with a travel of many encoder steps."""
    levels = level_parameters(machine, scales)
    shortest = scales.presliding_travel
    travel = parameter(
        "travel",
        machine.unit("position"),
        shortest,
        lower=shortest,
        upper=max(0.1 * scales.travel, 10.0 * shortest),
        starts=(2.0 * shortest, 20.0 * shortest, 200.0 * shortest),
    )
    return [
        Form(
            effect=EFFECT.id,
            name="Dahl, long travel",
            parameters=(*levels, travel),
            apply=apply_bristles(machine, scales),
            where=at("elements", "level_"),
            shapes=frozenset({"travel"}),
            removable=frozenset(p.name for p in levels),
            family=FAMILY,
            price=RARE,
        )
    ]


EFFECT = Effect(
    id="friction.presliding",
    summary="elastic, hysteretic displacement before sliding (Dahl, LuGre, Maxwell slip)",
    forms=forms,
    signature="unexplained torque that builds up like a spring after each reversal",
)
