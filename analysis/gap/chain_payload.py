"""A rotor inertia or load mass of a closed chain that the nominal model has wrong."""

from typing import TYPE_CHECKING

import numpy as np

from .effects.base import Form, Values, at, parameter
from .effects.inertia_payload import EFFECT

if TYPE_CHECKING:
    from .chain_machine import ChainMachine, ChainPlant


def forms(machine: "ChainMachine") -> list[Form]:
    """More or less inertia of every rotor, and kilograms at the parts that carry a load."""
    loads = [name for name in machine.chain.parts() if name != "machine"]
    rotor = next(p for p in machine.own if p.name == "rotor_inertia")
    parameters = (
        parameter("extra_rotors", rotor.unit, 0.2 * rotor.scale),
        *(parameter(f"extra_{name}", "kg", 0.5) for name in loads),
    )

    def apply(plant: "ChainPlant", values: Values) -> None:
        n = len(machine.joints)
        plant.inertia[-n:, -n:] += values.get("extra_rotors", 0.0) * np.eye(n)
        for i, name in enumerate(loads, start=1):
            plant.weights[i] += values.get(f"extra_{name}", 0.0)

    return [
        Form(
            effect=EFFECT.id,
            name="added inertia",
            parameters=parameters,
            apply=apply,
            where=at("axes", "extra_"),
            removable=frozenset(p.name for p in parameters),
            takes={
                "extra_rotors": "rotor_inertia",
                **{f"extra_{name}": "machine_inertia" for name in loads},
            },
        )
    ]
