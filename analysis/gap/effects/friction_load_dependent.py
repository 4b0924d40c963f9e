"""Friction that grows with the transmitted torque."""

from ....models.drive import LOAD_FRICTION, LOAD_WIDTH, NET_LOAD_FRICTION
from .base import Effect, Form, Scales, ShaftMachine, ShaftPlant, Values, at, parameter
from .dry_friction import width_parameter


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """A share of each shaft's drive torque, or of what a bias leaves of it, that is lost to friction."""
    width = width_parameter(machine, scales)
    shares = tuple(parameter(f"share_{s}", "-", 0.1, lower=0.0, upper=0.9) for s in machine.joints)

    def form(name: str, column: int) -> Form:
        def apply(plant: ShaftPlant, values: Values) -> None:
            for j, s in enumerate(machine.joints):
                plant.drive.shaft[j, column] += values.get(f"share_{s}", 0.0)
            plant.drive.shaft[:, LOAD_WIDTH] = values["width"]

        return Form(
            effect=EFFECT.id,
            name=name,
            parameters=(*shares, width),
            apply=apply,
            where=at("joints", "share_"),
            removable=frozenset(p.name for p in shares),
            shapes=frozenset({width.name}),
        )

    return [
        form("share of the motor torque", LOAD_FRICTION),
        form("share of the load beyond a bias", NET_LOAD_FRICTION),
    ]


EFFECT = Effect(
    id="friction.load_dependent",
    summary="friction that grows with transmitted load or motor torque",
    forms=forms,
    signature="unexplained torque that steps with the speed's sign and grows with the torque",
)
