"""Which assumption moves the table's printed numbers, and how far: one changed at a time, in the z motion.

Bandwidths of about 4 Hz without and 3.5 Hz with the table are printed beside gains and phases at three frequencies
(Roldan, section 4.2.4). The variants ask whether any one loop has them all.
"""

from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...models.belt_axis import IDENTIFIED, MANUFACTURER, BeltAxis
from ...models.belt_control import Gains
from ...models.parallel import mast
from ...models.parallel.prs import Table
from .mast_bandwidth import PRINTED, Response, response

FREQUENCIES = (0.4, 2.0, 3.0, 3.5, 4.0, 4.5, 5.0, 10.0)  # [Hz]
FRICTION_BOUND = (
    "speed loop of 300 rad/s without integral, axes alone with the manufacturers' friction"
)


@dataclass(frozen=True, kw_only=True)
class Setting:
    """What a variant simulates."""

    gains: Gains
    loaded: BeltAxis = IDENTIFIED
    alone: BeltAxis = IDENTIFIED
    size: float = 4e-3  # of the sine [m]
    model: Table = field(default_factory=lambda: mast.MAST)


@dataclass(frozen=True, kw_only=True)
class Variant:
    """One changed assumption."""

    name: str
    loaded: Response  # with the table
    alone: Response

    @property
    def shift(self) -> float:
        """What the table does to the frequency of -3 dB [Hz]; printed as about -0.5."""
        return self.loaded.bandwidth - self.alone.bandwidth


def settings(gains: Gains) -> dict[str, Setting]:
    """Variants about assumed gains; each range is one a machine of this kind could have."""

    def tuned(**changed: float) -> Setting:
        return Setting(gains=replace(gains, **changed))

    base = Setting(gains=gains)
    table = mast.MAST
    inertia: Any = tuple(3.0 * i for i in table.platform_inertia)
    heavy = replace(table, platform_mass=3.0 * table.platform_mass, platform_inertia=inertia)
    belt, dry = replace(IDENTIFIED, lead=0.1), replace(IDENTIFIED, coulomb=2.0 * IDENTIFIED.coulomb)
    slack = replace(gains, position_gain=23.0, velocity_bandwidth=300.0, integral_corner=0.1)
    return {
        "as assumed": base,
        "k_v of 18 1/s": tuned(position_gain=18.0),
        "k_v of 24 1/s": tuned(position_gain=24.0),
        "position loop every 15 ms": tuned(position_period=0.015),
        "speed loop of 60 rad/s": tuned(velocity_bandwidth=60.0),
        "speed loop of 160 rad/s": tuned(velocity_bandwidth=160.0),
        "speed loop without integral": tuned(integral_corner=0.1),
        "sine of 2 mm": replace(base, size=2e-3),
        "sine of 20 mm": replace(base, size=20e-3),
        "belt of 100 mm/rev": replace(base, loaded=belt, alone=belt),
        "twice the Coulomb friction": replace(base, loaded=dry, alone=dry),
        "axes alone with the manufacturers' friction": replace(base, alone=MANUFACTURER),
        "platform of three times the mass": replace(base, model=heavy),
        FRICTION_BOUND: Setting(gains=slack, alone=MANUFACTURER),
    }


def variants(gains: Gains, names: tuple[str, ...] | None = None) -> list[Variant]:
    """Responses of the settings of those names, by default of all."""
    chosen = settings(gains)
    return [
        Variant(
            name=name,
            loaded=_response(s, s.loaded, table=True),
            alone=_response(s, s.alone, table=False),
        )
        for name, s in chosen.items()
        if names is None or name in names
    ]


def printed_bandwidth() -> float:
    """-3 dB that the printed gains and phases have between them [Hz].

    Each printed pair is that of an open loop K exp(-j w T)/(j w); K and T are taken on lines between their frequencies.
    """
    f = np.array(list(PRINTED))
    pairs = np.array(list(PRINTED.values()))
    closed = pairs[:, 0] * np.exp(1j * np.deg2rad(pairs[:, 1]))
    opened = closed / (1.0 - closed) * 2j * np.pi * f
    between = np.linspace(f[0], f[-1], 2000)
    w = 2.0 * np.pi * between
    size = np.interp(between, f, np.abs(opened))
    lag = np.interp(between, f, -np.angle(opened) / (2.0 * np.pi * f))
    loop: NDArray[np.complex128] = size * np.exp(-1j * w * lag) / (1j * w)
    below = np.abs(loop / (1.0 + loop)) < np.sqrt(0.5)
    return float(between[np.argmax(below)])


def _response(s: Setting, axis: BeltAxis, *, table: bool) -> Response:
    return response(
        "z", axis, s.gains, table=table, frequencies=FREQUENCIES, size=s.size, model=s.model
    )
