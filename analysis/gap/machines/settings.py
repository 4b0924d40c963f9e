"""Reading the settings of machines and controllers from a log set, key by key."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ...errors import InputError
from ..logset import FILE, LogSet

DEFAULT_TOLERANCE = 0.03


class Settings:
    """A mapping whose every key must be known and whose numbers must be numbers."""

    def __init__(self, where: str, values: Mapping[str, Any], known: set[str]) -> None:
        self._where = where
        self._values = values
        unknown = sorted(str(key) for key in values if key not in known)
        if unknown:
            raise InputError(
                where, f"unknown key {unknown[0]!r}", f"one of {', '.join(sorted(known))}"
            )

    def number(self, key: str, default: float | None = None, *, positive: bool = False) -> float:
        """A finite number; without a default the key is required."""
        value = self._values.get(key, default)
        wanted = "a positive number" if positive else "a finite number"
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise InputError(f"{self._where}.{key}", f"{value!r}", wanted)
        if not abs(value) < np.inf or (positive and value <= 0.0):
            raise InputError(f"{self._where}.{key}", f"{value!r}", wanted)
        try:
            return float(value)
        except OverflowError:  # an integer of hundreds of digits
            raise InputError(f"{self._where}.{key}", f"{value!r:.40}...", wanted) from None


def nominal_settings(logset: LogSet, known: set[str]) -> Settings:
    """``system.nominal`` with its known keys."""
    check_system(logset)
    nominal = logset.system.get("nominal", {})
    where = f"{logset.folder / FILE}, system.nominal"
    if not isinstance(nominal, dict):
        raise InputError(where, f"{nominal!r}", "a mapping of parameters")
    return Settings(where, nominal, known | {"note"})


def check_system(logset: LogSet) -> None:
    """Refuse unknown keys beside ``kind`` and ``nominal``."""
    Settings(
        f"{logset.folder / FILE}, system",
        logset.system,
        {"kind", "nominal", "tolerance", "limits", "description", "note"},
    )


def tolerance(logset: LogSet) -> float:
    """Relative tolerance of the nominal parameters, ``system.tolerance`` or 3 %."""
    value = logset.system.get("tolerance", DEFAULT_TOLERANCE)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 <= value < 1.0:
        raise InputError(
            f"{logset.folder / FILE}, system.tolerance", f"{value!r}", "a number from 0 to 1"
        )
    return float(value)


def require_units(logset: LogSet, expected: Mapping[str, str]) -> None:
    """Refuse a missing column or a unit other than the expected one."""
    for name, unit in expected.items():
        where = f"{logset.folder / FILE}, columns.{name}"
        if name not in logset.units:
            raise InputError(where, "no such column", f"`{name}: {unit}`")
        if logset.units[name].replace(" ", "") != unit.replace(" ", ""):
            raise InputError(
                where,
                f"the unit is {logset.units[name]!r}",
                f"{unit}",
                "Convert the column, or correct the unit if only the text is wrong.",
            )


def require_controllers(logset: LogSet, kind: str) -> None:
    """Refuse a controller of another kind."""
    for name, settings in logset.controllers.items():
        if settings.get("kind") != kind:
            raise InputError(
                f"{logset.folder / FILE}, controllers.{name}.kind",
                f"{settings.get('kind')!r}",
                kind,
            )
