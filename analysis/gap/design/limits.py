"""Limits a designed motion must keep: task positions, speed of every shaft, effort of every shaft."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...errors import InputError
from ..description import FILE
from ..drive_machine import DriveMachine
from ..machine import Array, Machine
from ..result import Diagnosis

# Extremes of the C-drive's benchmark: Table 5-2 (travel; half a turn either way), translation at
# 2 Hz (speed) and the largest printed torque, Table 5-5.
C_DRIVE: dict[str, Any] = {
    "translation": (-0.2, 0.0),  # m
    "rotation": (-np.pi, np.pi),  # rad
    "speed": 183.3,
    "effort": 3.4247,
}


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Bounds of a motion that starts at zero."""

    lower: Array  # (task,) of every task coordinate, in the unit of machine.task_map
    upper: Array  # (task,)
    speed: float  # of every shaft [position unit/s]
    effort: float  # of every shaft [effort unit]
    source: str  # where they come from, in words

    def to_json(self, task: tuple[str, ...]) -> dict[str, Any]:
        """Numbers by name."""
        ranges = {n: [float(a), float(b)] for n, a, b in zip(task, self.lower, self.upper)}
        return {**ranges, "speed": self.speed, "effort": self.effort, "source": self.source}


def drive_of(machine: Machine) -> DriveMachine:
    """The machine, which must be a drive: only those have motion programs to design."""
    if not isinstance(machine, DriveMachine):
        raise InputError(
            "design",
            f"no motions are designed for system.kind {machine.kind!r}",
            "c_drive or slider",
        )
    return machine


def limits_of(
    diagnosis: Diagnosis,
    *,
    ranges: Mapping[str, tuple[float, float]] | None = None,
    speed: float | None = None,
    effort: float | None = None,
) -> Limits:
    """Limits of the diagnosed machine: the given ones, then ``system.limits``, then defaults.

    Defaults are the benchmark's extremes for a C-drive and otherwise what the log set has already
    asked of the machine. Raises InputError for an unknown or impossible limit.
    """
    machine, log = drive_of(diagnosis.machine), diagnosis.logset
    where = f"{log.folder / FILE}, system.limits"
    stated = log.system.get("limits", {})
    known = [*machine.task, "speed", "effort"]
    if not isinstance(stated, Mapping):
        raise InputError(where, f"{stated!r}", f"a mapping with keys among {', '.join(known)}")
    given: dict[str, Any] = dict(ranges or {})
    given.update({k: v for k, v in (("speed", speed), ("effort", effort)) if v is not None})
    for place, keys in ((where, stated), ("limits", given)):
        for key in keys:
            if key not in known:
                raise InputError(place, f"unknown limit {key!r}", f"one of {', '.join(known)}")
    defaults = C_DRIVE if machine.kind == "c_drive" else _logged(diagnosis)
    values = {**defaults, **stated, **given}
    used = [
        "options" if given else "",
        "system.limits" if stated else "",
        "" if set(known) <= {*given, *stated} else _default_words(machine.kind),
    ]
    bounds = np.array([_range(where, name, values[name]) for name in machine.task])
    return Limits(
        lower=bounds[:, 0],
        upper=bounds[:, 1],
        speed=_positive(where, "speed", values["speed"]),
        effort=_positive(where, "effort", values["effort"]),
        source=", then ".join(word for word in used if word),
    )


def _default_words(kind: str) -> str:
    return "the benchmark's extremes" if kind == "c_drive" else "the extremes of the logged runs"


def _logged(diagnosis: Diagnosis) -> dict[str, Any]:
    machine, runs = drive_of(diagnosis.machine), diagnosis.runs
    place = np.concatenate([(r.reference - r.reference[0]) @ machine.task_map.T for r in runs])
    values: dict[str, Any] = {
        name: (float(low), float(high))
        for name, low, high in zip(machine.task, place.min(axis=0), place.max(axis=0))
    }
    values["speed"] = max(float(np.max(np.abs(r.reference_rate))) for r in runs)
    values["effort"] = max(float(np.max(np.abs(r.command))) for r in runs)
    return values


def _range(where: str, name: str, value: Any) -> tuple[float, float]:
    try:
        low, high = (float(v) for v in value)
    except (TypeError, ValueError):
        raise InputError(f"{where}.{name}", f"{value!r}", "two numbers, lowest, highest") from None
    if not (np.isfinite([low, high]).all() and low <= 0.0 <= high):
        raise InputError(
            f"{where}.{name}",
            f"{low:g} to {high:g}",
            "finite bounds with zero between them",
            "Motions start at zero, where the runs start.",
        )
    return low, high


def _positive(where: str, name: str, value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < np.inf:
        raise InputError(f"{where}.{name}", f"{value!r}", "a positive number")
    return float(value)
