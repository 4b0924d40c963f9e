"""Torque periodic in position: cogging, commutation, a bent screw."""

from collections.abc import Callable

import numpy as np

from ....models.drive import RIPPLE_COS, RIPPLE_SIN, RIPPLE_WAVENUMBER
from ..machine import Parameter
from .base import Effect, Form, Scales, Scan, ShaftMachine, ShaftPlant, Values, at, parameter

FEWEST_PERIODS = 3.0  # of a ripple in the travel: fewer are any smooth law of position
PERIODS_SAMPLES = 4.0  # samples of a period at the typical speed, at least
MOST_PERIODS = 100.0  # in the travel
OVERSAMPLED = 3  # wavenumbers that are tried per one that the travel resolves


def forms(machine: ShaftMachine, scales: Scales) -> list[Form]:
    """One form for each spatial frequency that machines of this kind show."""
    parameters = _amplitudes(machine, scales)
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


def scan(machine: ShaftMachine, scales: Scales) -> Scan:
    """Ripples of every period that the travel resolves, equally spaced in wavenumber."""
    lowest = 2.0 * np.pi * FEWEST_PERIODS / scales.travel
    seen = 2.0 * np.pi / (PERIODS_SAMPLES * max(scales.rate, 1e-300) * scales.dt)
    highest = min(seen, 2.0 * np.pi * MOST_PERIODS / scales.travel)
    step = 2.0 * np.pi / (OVERSAMPLED * scales.travel)
    resolved = OVERSAMPLED * step
    amplitudes = _amplitudes(machine, scales)

    def form(period: float) -> Form:
        wavenumber = 2.0 * np.pi / period
        shape = parameter(
            "period", machine.unit("position"), period, starts=(period,),
            lower=2.0 * np.pi / (wavenumber + resolved), upper=2.0 * np.pi / (wavenumber - resolved),
        )  # fmt: skip

        def apply(plant: ShaftPlant, values: Values) -> None:
            _ripple(machine, 2.0 * np.pi / (values.get("period", period)))(plant, values)

        return Form(
            effect=EFFECT.id,
            name="period found in the data",
            parameters=(*amplitudes, shape),
            apply=apply,
            where=_places,
            removable=frozenset(p.name for p in amplitudes),
            shapes=frozenset({"period"}),
            own_start=True,
        )

    periods = 2.0 * np.pi / np.arange(lowest, highest, step)
    return Scan(effect=EFFECT.id, shape="period", values=periods, form=form)


def _amplitudes(machine: ShaftMachine, scales: Scales) -> tuple[Parameter, ...]:
    return tuple(
        parameter(f"{part}_{s}", machine.unit("effort"), 0.1 * scales.effort, starts=(0.0,))
        for s in machine.joints
        for part in ("cos", "sin")
    )


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
    scan=scan,
)
