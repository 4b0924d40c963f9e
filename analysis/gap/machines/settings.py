"""Reading the settings of machines, controllers and runs from a log set, key by key."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...errors import InputError
from ..checks import as_float, finite_number, refuse_unknown, shown
from ..description import FILE, MOVE_KINDS
from ..logset import LogSet, Run

DEFAULT_TOLERANCE = 0.03
# Keys that a run of any machine may have. A motion that repeats states its rate or its period.
RUN_KEYS = frozenset({"motion", "rate_Hz", "period_s", "start_s", "note"})
LONGEST_RUNNING = 1e9  # [s] that a machine can have been running before a run, 30 years
MOST_RUNS = 10  # lengths of a run that a cycle may have: a run may be part of one
LARGEST = 1e9  # no position, command or effort of a machine here, in whatever unit, is as large


class Settings:
    """A mapping whose every key must be known and whose numbers must be numbers."""

    def __init__(self, where: str, values: Mapping[str, Any], known: Collection[str]) -> None:
        self.where = where
        self.values = values
        refuse_unknown(where, values, known)

    def number(
        self,
        key: str,
        default: float | None = None,
        *,
        positive: bool = False,
        least: float | None = None,
    ) -> float:
        """A finite number, positive or at least ``least``; without a default the key is required."""
        value = self.values.get(key, default)
        above = 0.0 if positive else None
        return finite_number(f"{self.where}.{key}", value, above=above, least=least)

    def numbers(
        self, key: str, count: int, default: Sequence[float] | None = None, **limits: float
    ) -> NDArray[np.float64]:
        """A list of ``count`` finite numbers within ``limits`` (``above``, ``least``)."""
        value = self.values.get(key, default)
        if not isinstance(value, list | tuple) or len(value) != count:
            raise InputError(f"{self.where}.{key}", shown(value), f"a list of {count} numbers")
        return np.array([
            finite_number(f"{self.where}.{key}[{i}]", one, **limits) for i, one in enumerate(value)
        ])  # fmt: skip

    def flag(self, key: str) -> bool:
        """Whether a key that may be left out is true."""
        value = self.values.get(key, False)
        if not isinstance(value, bool):
            raise InputError(f"{self.where}.{key}", shown(value), "true or false")
        return value

    def text(self, key: str, default: str) -> str:
        """A name or a finite number as text."""
        value = self.values.get(key, default)
        if not isinstance(value, str) and not np.isfinite(as_float(value)):
            raise InputError(f"{self.where}.{key}", shown(value), "a name")
        return str(value)


class RunSettings(Settings):
    """What a log set says of one run, with the keys of ``RUN_KEYS`` checked."""

    def __init__(self, where: str, run: Run, dt: float, known: Collection[str]) -> None:
        super().__init__(where, run.settings, RUN_KEYS | set(known))
        self.start = self.number("start_s", 0.0, least=0.0)  # had been running before the run [s]
        if self.start > LONGEST_RUNNING:
            raise InputError(
                f"{where}.start_s", f"{self.start:g}", f"at most {LONGEST_RUNNING:g} seconds"
            )
        self.text("motion", "")
        self.seconds = self._seconds()  # of one cycle, None where the motion does not repeat
        if dt > 0.0 and self.seconds is not None:
            self._check_period(run, dt, self.seconds)

    def period(self, dt: float) -> int | None:
        """Samples of one cycle at a sample time of ``dt`` [s]."""
        return None if self.seconds is None else round(self.seconds / dt)

    def _seconds(self) -> float | None:
        stated = {
            key: self.number(key, positive=True)
            for key in ("rate_Hz", "period_s")
            if key in self.values
        }
        periods = [1.0 / v if key == "rate_Hz" else v for key, v in stated.items()]
        if len(periods) == 2 and abs(periods[0] - periods[1]) > 1e-3 * periods[1]:
            raise InputError(
                self.where,
                f"rate_Hz {stated['rate_Hz']:g} and period_s {stated['period_s']:g} contradict",
                "one of both",
            )
        return periods[-1] if periods else None

    def _check_period(self, run: Run, dt: float, seconds: float) -> None:
        key = "period_s" if "period_s" in self.values else "rate_Hz"
        longest = (
            MOST_RUNS * run.samples if run.whole else np.inf
        )  # stretches hold parts of a cycle
        if not 2.0 <= seconds / dt <= longest:
            raise InputError(
                f"{self.where}.{key}",
                f"{self.values[key]:g}, a cycle of {seconds / dt:.3g} samples",
                f"2 samples at least and {MOST_RUNS} times the run of {run.samples} samples at most",
                "Leave it out where the motion does not repeat.",
            )


def run_settings(logset: LogSet, run: Run, *known: str) -> RunSettings:
    """The settings of a run, of ``RUN_KEYS`` and the ``known`` ones of its machine."""
    clocked = not logset.uneven and logset.kind not in MOVE_KINDS
    dt = logset.dt if clocked else 0.0
    return RunSettings(f"{logset.folder / FILE}, runs[{run.name}]", run, dt, known)


def nominal_settings(logset: LogSet, known: set[str]) -> Settings:
    """``system.nominal`` with its known keys."""
    check_system(logset)
    nominal = logset.system.get("nominal", {})
    where = f"{logset.folder / FILE}, system.nominal"
    if not isinstance(nominal, dict):
        raise InputError(where, shown(nominal), "a mapping of parameters")
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
    where = f"{logset.folder / FILE}, system.tolerance"
    value = finite_number(where, logset.system.get("tolerance", DEFAULT_TOLERANCE), least=0.0)
    if not value < 1.0:
        raise InputError(where, f"{value:g}", "a number from 0 to 1")
    return value


def require_units(logset: LogSet, expected: Mapping[str, str]) -> None:
    """Refuse a missing column, a unit other than the expected one, or values beyond any machine."""
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
        require_sizes(logset, name)


def require_sizes(logset: LogSet, column: str) -> None:
    """Refuse values of a column that no machine can have had."""
    for run in logset.runs:
        values = np.abs(run.columns[column])
        worst = int(np.argmax(values))
        if values[worst] >= LARGEST:
            raise InputError(
                f"{logset.folder / run.name}, column {column}",
                f"{run.columns[column][worst]:g} at t = {run.columns['t'][worst]:g} s",
                f"less than {LARGEST:g} {logset.units[column]}",
                "Check the unit and the decimal point of the column.",
            )


def require_controllers(logset: LogSet, kind: str) -> None:
    """Refuse a controller of another kind."""
    for name, settings in logset.controllers.items():
        if settings.get("kind") != kind:
            raise InputError(
                f"{logset.folder / FILE}, controllers.{name}.kind",
                shown(settings.get("kind")),
                kind,
            )
