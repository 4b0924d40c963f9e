"""A wrong gain of an encoder that loop and log both see."""

import numpy as np

from .base import Effect, Form, Scales, ShaftMachine, ShaftPlant, Values, at, everywhere, parameter


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """One scale error of all encoders, such as a wrong count; a second form lets each have its own."""
    parameters = tuple(
        parameter(f"scale_error_{s}", "-", 0.2, lower=-0.5, upper=1.0, starts=(0.0,))
        for s in machine.joints
    )

    def apply(plant: ShaftPlant, values: Values) -> None:
        plant.sensor_scale = np.array(
            [1.0 + values.get(f"scale_error_{s}", 0.0) for s in machine.joints]
        )

    each = Form(
        effect=EFFECT.id,
        name="scale of each encoder",
        parameters=parameters,
        apply=apply,
        where=at("joints", "scale_error_"),
        removable=frozenset(p.name for p in parameters),
    )
    if len(machine.joints) == 1:
        return [each]

    def apply_common(plant: ShaftPlant, values: Values) -> None:
        plant.sensor_scale = np.full(len(machine.joints), 1.0 + values["scale_error"])

    common = Form(
        effect=EFFECT.id,
        name="common scale",
        parameters=(parameter("scale_error", "-", 0.2, lower=-0.5, upper=1.0, starts=(0.0,)),),
        apply=apply_common,
        where=everywhere("joints", machine.joints),
    )
    return [common, each]


EFFECT = Effect(
    id="sensor.scale",
    summary="encoder gain",
    forms=forms,
    signature="unexplained torque as if every coefficient of one joint were scaled",
)
