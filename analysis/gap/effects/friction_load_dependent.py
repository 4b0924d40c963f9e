"""Friction that grows with the transmitted torque."""

from ....models.drive import LOAD_FRICTION, LOAD_WIDTH
from .base import Effect, Form, Scales, ShaftMachine, ShaftPlant, Values, at, parameter
from .dry_friction import width_parameter


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """A share of each shaft's drive torque that is lost to friction."""
    width = width_parameter(machine, scales)
    shares = tuple(parameter(f"share_{s}", "-", 0.1, lower=0.0, upper=0.9) for s in machine.joints)

    def apply(plant: ShaftPlant, values: Values) -> None:
        for j, s in enumerate(machine.joints):
            plant.drive.shaft[j, LOAD_FRICTION] += values.get(f"share_{s}", 0.0)
        plant.drive.shaft[:, LOAD_WIDTH] = values["width"]

    return [
        Form(
            effect=EFFECT.id,
            name="share of the motor torque",
            parameters=(*shares, width),
            apply=apply,
            where=at("joints", "share_"),
            removable=frozenset(p.name for p in shares),
            shapes=frozenset({width.name}),
        )
    ]


EFFECT = Effect(
    id="friction.load_dependent",
    summary="friction that grows with transmitted load or motor torque",
    forms=forms,
    signature="unexplained torque that steps with the speed's sign and grows with the torque",
)
