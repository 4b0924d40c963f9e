"""Torque periodic in position: cogging, commutation, a bent screw."""

from collections.abc import Callable

from ....models.drive import RIPPLE_COS, RIPPLE_SIN, RIPPLE_WAVENUMBER
from .base import Effect, Form, Scales, ShaftMachine, ShaftPlant, Values, at, parameter


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """One form for each spatial frequency that machines of this kind show."""
    parameters = tuple(
        parameter(f"{part}_{s}", machine.unit("effort"), 0.1 * scales.effort, starts=(0.0,))
        for s in machine.joints
        for part in ("cos", "sin")
    )
    return [
        Form(
            effect=EFFECT.id,
            name=f"period {period}",
            parameters=parameters,
            apply=_ripple(machine, wavenumber),
            where=_places,
            removable=frozenset(p.name for p in parameters),
            own_start=True,
        )
        for period, wavenumber in machine.ripples.items()
    ]


def _ripple(machine: ShaftMachine, wavenumber: float) -> Callable[[ShaftPlant, Values], None]:
    def apply(plant: ShaftPlant, values: Values) -> None:
        for j, s in enumerate(machine.joints):
            plant.drive.shaft[j, RIPPLE_WAVENUMBER] = wavenumber
            plant.drive.shaft[j, RIPPLE_COS] += values.get(f"cos_{s}", 0.0)
            plant.drive.shaft[j, RIPPLE_SIN] += values.get(f"sin_{s}", 0.0)

    return apply


def _places(names: object) -> dict[str, list[str]]:
    found = {**at("joints", "cos_")(names), "more": at("joints", "sin_")(names)["joints"]}  # type: ignore[arg-type]
    return {"joints": sorted({*found["joints"], *found["more"]})}


EFFECT = Effect(
    id="actuator.ripple",
    summary="torque periodic in position (cogging, commutation)",
    forms=forms,
    signature="unexplained torque that repeats with position, whatever the speed",
)
