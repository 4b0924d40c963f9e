"""A wrong gain from command to torque."""

from ....models.drive import GAIN
from ..machine import Parameter
from .base import Effect, Form, Scales, ShaftMachine, ShaftPlant, Values, at, everywhere, parameter


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """One gain error for all actuators; a second form lets each have its own."""

    def bounded(name: str) -> Parameter:
        return parameter(name, "-", 0.2, lower=-0.8, upper=3.0, starts=(0.0,))

    common = Form(
        effect=EFFECT.id,
        name="common gain",
        parameters=(bounded("gain_error"),),
        apply=_apply_common,
        where=everywhere("joints", machine.joints),
    )
    if len(machine.joints) == 1:
        return [common]
    each = tuple(bounded(f"gain_error_{s}") for s in machine.joints)

    def apply(plant: ShaftPlant, values: Values) -> None:
        for j, s in enumerate(machine.joints):
            plant.drive.shaft[j, GAIN] *= 1.0 + values.get(f"gain_error_{s}", 0.0)

    own = Form(
        effect=EFFECT.id,
        name="gain of each actuator",
        parameters=each,
        apply=apply,
        where=at("joints", "gain_error_"),
        removable=frozenset(f"gain_error_{s}" for s in machine.joints),
    )
    return [common, own]


def _apply_common(plant: ShaftPlant, values: Values) -> None:
    plant.drive.shaft[:, GAIN] *= 1.0 + values["gain_error"]


EFFECT = Effect(
    id="actuator.torque_constant",
    summary="wrong gain from command to torque",
    forms=forms,
    signature="unexplained torque proportional to the commanded torque",
)
