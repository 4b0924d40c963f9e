"""Wrong or missing velocity-proportional friction."""

from collections.abc import Sequence

from ....models.drive import VISCOUS, VISCOUS_SKEW
from ..machine import Parameter
from .base import RARE, Effect, Form, Scales, ShaftMachine, ShaftPlant, Values, at, parameter


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """Extra coefficient of each friction element, and what it has more forward than backward."""
    scale = scales.effort / scales.rate
    extra = [
        parameter(f"viscous_{e}", machine.unit("viscous"), scale, starts=(0.0,))
        for e in machine.elements
    ]
    skew = [
        parameter(f"skew_{e}", machine.unit("viscous"), scale, starts=(0.0,))
        for e in machine.elements
    ]

    def apply(plant: ShaftPlant, values: Values) -> None:
        for i, e in enumerate(machine.elements):
            plant.drive.element[i, VISCOUS] += values.get(f"viscous_{e}", 0.0)
            plant.drive.element[i, VISCOUS_SKEW] += values.get(f"skew_{e}", 0.0)

    def form(name: str, free: Sequence[Parameter], *, refined: bool) -> Form:
        return Form(
            effect=EFFECT.id,
            name=name,
            parameters=tuple(free),
            apply=apply,
            where=at("elements", "viscous_"),
            removable=frozenset(p.name for p in free),
            takes={p.name: own for p, own in zip(extra, machine.viscous_own, strict=True)},
            refined=refined,
            price=RARE if refined else 0.0,
        )

    return [
        form("linear", extra, refined=False),
        form("linear, by direction", [*extra, *skew], refined=True),
    ]


EFFECT = Effect(
    id="friction.viscous",
    summary="wrong or missing velocity-proportional friction",
    forms=forms,
    signature="unexplained torque proportional to speed",
)
