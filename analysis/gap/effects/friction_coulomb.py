"""Dry friction whose level does not depend on speed; may differ by element and direction."""

from ..machine import Parameter
from .base import RARE, Effect, Form, Scales, ShaftMachine, at
from .dry_friction import (
    FAMILY,
    apply_bristles,
    apply_smooth_sign,
    asymmetry_parameter,
    asymmetry_parameters,
    level_parameters,
    travel_parameter,
    width_parameter,
)


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """Levels by element and direction, with a smoothed sign or with bristles (Dahl)."""
    levels = level_parameters(machine, scales)
    width = width_parameter(machine, scales)
    travel = travel_parameter(machine, scales)

    def form(name: str, shape: Parameter, *, by_direction: bool) -> Form:
        law = apply_smooth_sign if shape is width else apply_bristles
        free = (*levels, *asymmetry_parameters(machine)) if by_direction else levels
        return Form(
            effect=EFFECT.id,
            name=f"{name}, by direction" if by_direction else name,
            parameters=(*free, shape),
            apply=law(machine, scales),
            where=at("elements", "level_"),
            shapes=frozenset({shape.name}),
            removable=frozenset(p.name for p in free),
            family=FAMILY,
            refined=by_direction,
            price=RARE if by_direction else 0.0,
        )

    found = [
        form(name, shape, by_direction=by_direction)
        for by_direction in (False, True)
        for name, shape in (("smoothed sign", width), ("Dahl", travel))
    ]
    return [*found, _one_way(machine, scales)] if len(machine.elements) > 1 else found


def _one_way(machine: ShaftMachine, scales: Scales) -> Form:
    """Every level larger by one share in one direction: what else looks like a load on all shafts."""
    levels = level_parameters(machine, scales)
    return Form(
        effect=EFFECT.id,
        name="smoothed sign, one direction heavier",
        parameters=(*levels, asymmetry_parameter("asymmetry"), width_parameter(machine, scales)),
        apply=apply_smooth_sign(machine, scales),
        where=at("elements", "level_"),
        shapes=frozenset({"width", "asymmetry"}),
        removable=frozenset(p.name for p in levels),
        family=FAMILY,
        refined=True,
        stands_for=frozenset({"load.bias"}),
    )


EFFECT = Effect(
    id="friction.coulomb",
    summary="dry friction; may differ by joint, side or direction",
    forms=forms,
    signature="unexplained torque that steps with the sign of the speed",
)
