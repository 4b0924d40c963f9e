"""Units as logs state them, and their factors to the units of a log set."""

import math
import re

# Unit: (quantity, factor to the first unit of that quantity).
UNITS: dict[str, tuple[str, float]] = {
    "s": ("time", 1.0), "ms": ("time", 1e-3), "us": ("time", 1e-6), "ns": ("time", 1e-9),
    "min": ("time", 60.0), "h": ("time", 3600.0),
    "rad": ("angle", 1.0), "mrad": ("angle", 1e-3), "urad": ("angle", 1e-6),
    "deg": ("angle", math.pi / 180.0), "rev": ("angle", 2.0 * math.pi),
    "m": ("length", 1.0), "cm": ("length", 1e-2), "mm": ("length", 1e-3), "um": ("length", 1e-6),
    "nm": ("length", 1e-9),
    "rad/s": ("rate", 1.0), "deg/s": ("rate", math.pi / 180.0), "rpm": ("rate", math.pi / 30.0),
    "m/s": ("speed", 1.0), "mm/s": ("speed", 1e-3),
    "Nm": ("torque", 1.0), "mNm": ("torque", 1e-3), "Ncm": ("torque", 1e-2),
    "N": ("force", 1.0), "mN": ("force", 1e-3), "kN": ("force", 1e3),
    "V": ("voltage", 1.0), "mV": ("voltage", 1e-3), "A": ("current", 1.0), "mA": ("current", 1e-3),
}  # fmt: skip
SPELLINGS = {
    "sec": "s", "secs": "s", "second": "s", "seconds": "s", "msec": "ms", "usec": "us", "μs": "us",
    "µs": "us", "nsec": "ns", "degree": "deg", "degrees": "deg", "°": "deg", "radian": "rad",
    "radians": "rad", "turn": "rev", "turns": "rev", "μm": "um", "µm": "um", "meter": "m",
    "metre": "m", "amp": "A", "amps": "A", "volt": "V", "volts": "V", "newton": "N",
}  # fmt: skip


def known_unit(text: str) -> str | None:
    """The unit in the spelling of ``UNITS``, or None for one that is not there."""
    bare = re.sub(r"[\s·*.]", "", text)
    for spelling in (bare, SPELLINGS.get(bare.lower(), "")):
        if spelling in UNITS:
            return spelling
    folded = {unit.lower(): unit for unit in reversed(UNITS)}
    return folded.get(bare.lower()) if len(bare) > 1 else None


def factor(source: str, target: str) -> float | None:
    """What a number in ``source`` is multiplied by to be in ``target``; None if they do not convert."""
    a, b = known_unit(source), known_unit(target)
    if a is None or b is None or UNITS[a][0] != UNITS[b][0]:
        return 1.0 if source.replace(" ", "") == target.replace(" ", "") else None
    return UNITS[a][1] / UNITS[b][1]
