"""A mass on the tip that the stated arm does not have: weight through J^T, and inertia.

How a stick-slip step depends on inertia has no law in Damani 2013 (section 5.4): it is a share by joint, or what
Chang and Li's slider makes of it, which falls back less the heavier it is and more the heavier its load
((2), (3) of ``slip_terms.py``).
"""

from ..effects.base import Effect, Form, Values, parameter
from ..machine import Parameter
from ..step_machine import StepMachine, StepPlant
from .base import ENDS, SIDES, UNITS, Moves, everywhere, fallbacks, grips, removable


def forms(machine: StepMachine, moves: Moves) -> list[Form]:
    """The weight alone, with a share of every step for the inertia, and with what the slider falls back."""
    if not moves.weighed:
        return []
    mass = parameter(
        "mass", "kg", machine.arm.mass_3, lower=-0.9 * machine.arm.mass_3, upper=0.1
    )  # fmt: skip
    shares = [parameter(f"inertia_{joint + 1}", "1", 0.05, lower=-0.9) for joint in moves.sides]

    def apply(plant: StepPlant, values: Values) -> None:
        plant.payload += values["mass"]
        for joint in moves.sides:
            plant.change[joint] += values.get(f"inertia_{joint + 1}", 0.0)

    choices: dict[str, list[Parameter]] = {"weight": [], "weight and inertia": shares}
    found = [
        Form(
            effect=EFFECT.id,
            name=name,
            parameters=(mass, *extra),
            apply=apply,
            where=everywhere(machine),
            removable=removable(extra),
        )
        for name, extra in choices.items()
    ]
    return [*found, _slider(machine, moves)]


def _slider(machine: StepMachine, moves: Moves) -> Form:
    link = machine.arm.mass_3
    mass = parameter(
        "mass", "kg", 0.2 * link, lower=-0.3 * link, upper=0.1, starts=(0.0, 0.3 * link)
    )
    rotary = [joint for joint in moves.extended if joint in moves.step]
    swings = {f"swing_{joint + 1}_{end}": joint for joint in rotary for end in ENDS}
    swings |= {
        f"swingload_{joint + 1}_{SIDES[side]}_{end}": joint
        for joint in rotary
        for side in moves.sides[joint]
        for end in ENDS
    }
    contact = [
        parameter(
            name, UNITS[j], 0.02 * moves.step[j], lower=-0.2 * moves.step[j], upper=0.2 * moves.step[j]
        )
        for name, j in swings.items()
    ]  # fmt: skip
    shapes = [*fallbacks(machine, moves), *grips(moves), *contact]

    def apply(plant: StepPlant, values: Values) -> None:
        plant.slip.mass += values["mass"]
        for joint in moves.step:
            n = joint + 1
            plant.slip.fallback[joint] = values[f"fallback_{n}"]
            plant.slip.grip[joint] = values[f"grip_{n}"]
        for name in swings:
            term, joint_text, *place = name.split("_")
            key = (
                int(joint_text) - 1,
                *(SIDES.index(p) if p in SIDES else ENDS.index(p) for p in place),
            )
            (plant.slip.swing if term == "swing" else plant.slip.swing_load)[key] = values.get(
                name, 0.0
            )

    return Form(
        effect=EFFECT.id,
        name="slider",
        parameters=(mass, *shapes),
        apply=apply,
        where=everywhere(machine),
        removable=removable(contact),
        shapes=frozenset(p.name for p in shapes),
        own_start=True,
    )


EFFECT = Effect(
    id="inertia.payload",
    summary="mass on the tip that the model does not have",
    forms=forms,
    signature="moves err with the load of every joint, as one mass on the tip would have them, and without load as a heavier slider",
)
