"""Everything ``gapscope bandwidth mast`` reports."""

from dataclasses import dataclass

from ...models.belt_axis import MANUFACTURER
from ...models.belt_control import Gains
from .mast_bandwidth import (
    MOTIONS,
    Response,
    TorqueComparison,
    compare_torques,
    posture_spread,
    response,
)
from .mast_variants import Variant, variants


@dataclass(frozen=True, kw_only=True)
class Study:
    """Its parts."""

    gains: Gains
    responses: list[Response]
    torques: list[TorqueComparison]
    resonances: tuple[float, float]  # of TF_2 and TF_1 [Hz]
    inertia_spread: float
    variants: list[Variant]  # the first as assumed


def study(gains: Gains | None = None) -> Study:
    """All responses and torques."""
    used = gains or Gains()
    responses = [response(m, gains=used) for m in MOTIONS]
    responses.append(response("z", gains=used, table=False))
    return Study(
        gains=used,
        responses=responses,
        torques=compare_torques(used),
        resonances=MANUFACTURER.resonances,
        inertia_spread=posture_spread(),
        variants=variants(used),
    )
