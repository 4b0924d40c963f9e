"""Forms of wrong masses in a model file: a payload, a heavier link, a tilted base."""

from typing import TYPE_CHECKING, Any

import numpy as np

from ....models.rigid_tree import PARAMETERS, point_mass
from ..effects.base import Form, Values, everywhere, parameter
from ..machine import Parameter
from ..rigid_machine import RigidPlant

if TYPE_CHECKING:
    from .model_file import Arm


def mass_forms(arm: "Arm") -> list[Form]:
    """A payload at its stated place or anywhere on its body, a heavier link, a tilted base."""
    first = len(arm.bodies)
    total = float(arm.inertia[:, 0].sum())
    carrier = arm.bodies[arm.carrier]
    mass = parameter("mass", "kg", 0.1 * total, lower=-0.5 * total)
    reach = max(2.0 * float(np.max(np.abs(arm.place))), 0.05)
    free = tuple(
        parameter(f"place_{axis}", "m", 0.2 * reach, lower=-reach, upper=reach, starts=(float(p),))
        for axis, p in zip("xyz", arm.place)
    )

    def carry(plant: RigidPlant, values: Values) -> None:
        place = [values.get(f"place_{axis}", p) for axis, p in zip("xyz", arm.place)]
        plant.phi[first : first + PARAMETERS] += values["mass"] * point_mass(np.array(place))

    def tilt(plant: RigidPlant, values: Values) -> None:
        plant.phi[-2:] += np.linalg.norm(arm.gravity) * np.array(
            [values["tilt_x"], values["tilt_y"]]
        )

    def form(effect: str, name: str, free: tuple[Parameter, ...], apply: Any, **more: Any) -> Form:
        where = more.pop("where", everywhere("bodies", [carrier]))
        return Form(effect=effect, name=name, parameters=free, apply=apply, where=where, **more)

    own = f"mass_factor_{carrier}"
    forms = [
        form("inertia.payload", "point mass", (mass,), carry, replaces=frozenset({own})),
        form("inertia.payload", "point mass, place free", (mass, *free), carry,
             own_start=True, shapes=frozenset(p.name for p in free), replaces=frozenset({own})),
    ]  # fmt: skip
    for i, body in enumerate(arm.bodies):
        if arm.inertia[i, 0] > 0.0:
            forms.append(_heavier(i, body))
    if np.linalg.norm(arm.gravity) > 0.0:
        angles = tuple(
            parameter(f"tilt_{axis}", "rad", 0.05, lower=-0.5, upper=0.5) for axis in "xy"
        )
        forms.append(
            form("load.bias", "tilted base", angles, tilt, where=everywhere("joints", arm.joints),
                 own_start=True)
        )  # fmt: skip
    return forms


def _heavier(i: int, body: str) -> Form:
    def apply(plant: RigidPlant, values: Values) -> None:
        plant.phi[i] += values[f"excess_{body}"]

    return Form(
        effect="inertia.payload",
        name=f"mass and inertia of {body}",
        parameters=(parameter(f"excess_{body}", "-", 0.2, lower=-0.9),),
        apply=apply,
        where=everywhere("bodies", [body]),
        replaces=frozenset({f"mass_factor_{body}"}),
        own_start=True,
    )
