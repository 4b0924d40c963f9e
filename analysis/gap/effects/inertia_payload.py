"""A mass or inertia that the nominal model does not have, or has wrong."""

from ..drive_machine import DriveMachine, DrivePlant
from .base import Effect, Form, Scales, Values, at, parameter


def forms(machine: DriveMachine, scales: Scales) -> list[Form]:
    """Extra mass or inertia along each payload axis of the machine."""
    parameters = tuple(
        parameter(f"extra_{axis.name}", axis.unit, axis.scale, starts=(0.0,))
        for axis in machine.payload
    )

    def apply(plant: DrivePlant, values: Values) -> None:
        n = len(machine.joints)
        for axis in machine.payload:
            plant.inertia[-n:, -n:] += values.get(f"extra_{axis.name}", 0.0) * axis.inertia

    return [
        Form(
            effect=EFFECT.id,
            name="added inertia",
            parameters=parameters,
            apply=apply,
            where=at("axes", "extra_"),
            removable=frozenset(p.name for p in parameters),
            takes={f"extra_{axis.name}": axis.own for axis in machine.payload},
        )
    ]


EFFECT = Effect(
    id="inertia.payload",
    summary="wrong mass or inertia, unmodelled payload",
    forms=forms,
    signature="unexplained torque proportional to acceleration",
)
