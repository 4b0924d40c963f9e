"""Time series of one held-out run: unexplained effort, command and tracking error, to zoom into."""

import base64
from itertools import pairwise
from typing import Any

import numpy as np

from ..machine import Array, RunData
from .base import Material, Section, rms

MOST_SAMPLES = 12_000  # of a series on the page; longer ones keep the extremes of every bucket
STEPS = 32_000  # of the integers that carry a series


def context(material: Material) -> dict[str, Any]:
    """Panels of the held-out run on which the nominal model fails most."""
    d = material.diagnosis
    nominal, after = material.efforts(d.nominal), material.efforts(d.chosen)
    index = int(np.argmax([rms(e) for e in nominal]))
    run = material.held_out[index]
    t = run.t[run.window]
    name = "diagnosed" if d.verdict.accepted else "retuned"
    fits = {"nominal": d.nominal, name: d.chosen}
    loops = {key: loop for key, fit in fits.items() if (loop := _loop(material, run, fit))}
    panels = []
    for j, shaft in enumerate(d.machine.joints):
        panels.append(
            _panel(f"Unexplained effort, {shaft}", d.machine.effort_unit,
                   {"nominal": nominal[index][:, j], name: after[index][:, j]})
        )  # fmt: skip
    commanded = d.machine.joints if run.command.shape == run.position.shape else ()
    for j, shaft in enumerate(commanded):
        series = {"measured": run.command[run.window][:, j]}
        series |= {key: command[:, j] for key, (command, _) in loops.items()}
        panels.append(_panel(f"Command, {shaft}", d.machine.effort_unit, series))
    for j, shaft in enumerate(d.machine.joints):
        series = {"measured": (run.reference - run.position)[run.window][:, j]}
        series |= {key: error[:, j] for key, (_, error) in loops.items()}
        panels.append(_panel(f"Tracking error, {shaft}", d.machine.position_unit, series))
    diverged = [key for key, pair in loops.items() if not np.all(np.isfinite(pair[0]))]
    return {
        "run": run.name,
        "settings": {k: v for k, v in run.settings.items() if k != "note"},
        "several": len(material.held_out) > 1,
        "diverged": diverged,
        "decimated": len(t) > MOST_SAMPLES,
        "most": MOST_SAMPLES,
        "samples": len(t),
        "data": {"start": float(t[0]), "end": float(t[-1]), "panels": panels},
    }


def _loop(material: Material, run: RunData, fit: Any) -> tuple[Array, Array] | None:
    """Command and tracking error of the whole loop on the model, on the run's window."""
    machine = material.diagnosis.machine
    loop = machine.simulate(run, fit.hypothesis.plant(machine, fit.by_key(), run.start))
    if loop is None:
        return None
    position, command = loop
    return command[run.window], (run.reference - position)[run.window]


def _panel(title: str, unit: str, series: dict[str, Array]) -> dict[str, Any]:
    return {
        "title": title,
        "unit": unit,
        "series": [
            {"name": name, "rms": rms(values), **packed(decimated(values, MOST_SAMPLES))}
            for name, values in series.items()
            if np.all(np.isfinite(values))
        ],
    }


def decimated(values: Array, most: int) -> Array:
    """At most ``most`` values: the smallest and the largest of every bucket, in their order."""
    if len(values) <= most:
        return values
    edges = np.linspace(0, len(values), most // 2 + 1).astype(int)
    kept = []
    for a, b in pairwise(edges):
        bucket = values[a:b]
        first, second = sorted((int(np.argmin(bucket)), int(np.argmax(bucket))))
        kept += [bucket[first], bucket[second]]
    return np.array(kept)


def packed(values: Array) -> dict[str, Any]:
    """The values as little-endian 16-bit integers in base64; value = offset + scale * integer."""
    low, high = float(np.min(values)), float(np.max(values))
    offset = 0.5 * (low + high)
    scale = (high - low) / STEPS or 1.0
    integers = np.rint((values - offset) / scale).astype("<i2")
    return {
        "offset": offset,
        "scale": scale,
        "data": base64.b64encode(integers.tobytes()).decode("ascii"),
    }


SECTION = Section(key="series", title="The signals of one held-out run", context=context)
