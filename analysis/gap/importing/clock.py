"""Signals of several clocks on one uniform clock; interpolation is never done unasked."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from ...errors import InputError
from ..sampling import JITTER_LIMIT, JITTER_TOLD, jitter, resampled
from ..tables import Array

ASK = "Pass --resample to have it interpolated; the log set will say so."


def sample_time(t: Array) -> float:
    """Interval [s] of increasing times: the mean, rounded where the rounding cannot be seen."""
    mean = float(t[-1] - t[0]) / (t.size - 1)
    for digits in range(1, 8):
        rounded = float(f"{mean:.{digits}g}")
        if abs(rounded - mean) * t.size < 0.02 * mean:
            return rounded
    return mean


def on_one_clock(
    path: Path,
    columns: Mapping[str, tuple[Array, Array]],
    base: Array,
    dt: float | None,
    resample: bool,
) -> tuple[dict[str, Array], float, list[str]]:
    """Columns on the uniform clock that begins with ``base`` (samples,) [s], its interval, and remarks.

    ``columns`` maps a name to its times [s] and values. ``dt`` [s] is the wanted interval, or None for
    that of ``base``. Raises InputError where interpolation is needed and ``resample`` is not set.
    """
    remarks: list[str] = []
    joined: dict[str, Array] = {}
    for name, (t, values) in columns.items():
        if t.size == base.size and np.array_equal(t, base):
            joined[name] = values
            continue
        if not resample:
            raise InputError(
                f"{path}, {name}", "it has another clock than the position", "one clock", ASK
            )
        inside = (base >= t[0]) & (base <= t[-1])
        if not inside.all():
            raise InputError(
                f"{path}, {name}", f"samples from {t[0]:.6g} to {t[-1]:.6g} s only",
                f"samples over {base[0]:.6g} to {base[-1]:.6g} s", "Cut the log to what all signals share.",
            )  # fmt: skip
        joined[name] = np.interp(base, t, values)
        remarks.append(
            f"{path.name}, {name}: {jitter(t)}; interpolated linearly to the clock of the others."
        )
    table = {"t": base - base[0], **joined}
    found = jitter(base)
    step = dt or sample_time(base)
    if abs(found.mean - step) > 1e-3 * step and not resample:
        raise InputError(
            path, f"samples every {found.mean:.6g} s", f"samples every {step:g} s",
            f"Bring all to one sample time: --sample-time {step:g} --resample",
        )  # fmt: skip
    ideal = step * np.arange(base.size)
    worst = max(
        float(np.max(np.abs(table["t"] - ideal))), found.longest - step, step - found.shortest
    )
    if worst > JITTER_LIMIT * step:
        if not resample:
            raise InputError(f"{path}, time", str(found), f"uniform steps of {step:g} s", ASK)
        table, notes = resampled(path, table, step)
        remarks.extend(notes)
    elif found.rms > JITTER_TOLD * step:
        remarks.append(f"{path.name}: {found}; taken as uniform.")
    return table, step, remarks
