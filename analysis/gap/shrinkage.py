"""How far the gap shrinks, on runs that were never used to fit or to choose."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...models import drive_kernels
from .fitting import Predictor
from .floor import noise_floor
from .hypothesis import Fit, Hypothesis
from .location import unexplained_effort
from .machine import Array, FinishedPlant, Machine, RunData

BLOCKS = 20  # per run
RESAMPLES = 1000


@dataclass(frozen=True, kw_only=True)
class Shrinkage:
    """Rms unexplained effort on the validation runs, four times, and what follows from it."""

    metric: str
    before: float
    retuned: float
    after: float
    floor: float
    percent: float | None
    ci95: tuple[float, float] | None
    relative_to_command: float  # rms command on the same samples
    floor_source: str
    runs: tuple[str, ...]


def shrinkage(
    machine: Machine,
    logged: Sequence[RunData],
    runs: Sequence[RunData],
    retuned: Fit,
    chosen: Fit,
    seed: int,
) -> Shrinkage:
    """Before, retuned, after and floor, with a block-bootstrap interval of the percent.

    ``logged`` are the validation runs as they came, ``runs`` the same with wrong signals corrected:
    before is the nominal model on the former, all else is on the latter.
    """
    nominal = machine.nominal()
    names = tuple(("", name) for name in nominal)
    raw = Predictor(machine, logged).residuals(
        Hypothesis(), [np.array(list(nominal.values()))], names
    )[0]
    predictor = Predictor(machine, runs)
    tuned = predictor.residuals(retuned.hypothesis, [retuned.values], retuned.keys)[0]
    after = predictor.residuals(chosen.hypothesis, [chosen.values], chosen.keys)[0]
    floors, source = noise_floor(runs, after, machine.bandwidth)
    parts = [
        _blocks([unexplained_effort(r, machine, runs[0].dt) for r in kind])
        for kind in (raw, tuned, after)
    ]
    floor = _rms_of([unexplained_effort(f, machine, runs[0].dt) for f in floors])
    before, retuned_rms, after_rms = (_rms(energy, count) for energy, count in parts)
    percent, interval = _percent(parts[0], parts[2], floor, seed)
    command = np.concatenate([run.command[run.window].ravel() for run in runs])
    return Shrinkage(
        metric=f"rms unexplained {machine.effort_unit} on held-out runs",
        before=before,
        retuned=retuned_rms,
        after=after_rms,
        floor=floor,
        percent=percent,
        ci95=interval,
        relative_to_command=float(np.sqrt(np.mean(command**2))),
        floor_source=source,
        runs=tuple(run.name for run in runs),
    )


def _percent(
    before: tuple[Array, Array], after: tuple[Array, Array], floor: float, seed: int
) -> tuple[float | None, tuple[float, float] | None]:
    """100 (before - after) / (before - floor) and its interval; None where nothing is above the floor."""
    top = _rms(*before)
    if top <= 1.05 * floor:
        return None, None
    rng = np.random.default_rng(seed)
    draws = rng.integers(0, len(before[0]), (RESAMPLES, len(before[0])))
    b = np.sqrt(before[0][draws].sum(axis=1) / before[1][draws].sum(axis=1))
    a = np.sqrt(after[0][draws].sum(axis=1) / after[1][draws].sum(axis=1))
    sampled = 100.0 * (b - a) / np.maximum(b - floor, 1e-12)
    low, high = np.quantile(sampled, [0.025, 0.975])
    return float(100.0 * (top - _rms(*after)) / (top - floor)), (float(low), float(high))


def _blocks(values: Sequence[Array]) -> tuple[Array, Array]:
    pieces = [p for v in values for p in np.array_split(v, BLOCKS, axis=0)]
    return np.array([np.sum(p**2) for p in pieces]), np.array([float(p.size) for p in pieces])


def _rms(energy: Array, count: Array) -> float:
    return float(np.sqrt(energy.sum() / count.sum()))


def _rms_of(values: Sequence[Array]) -> float:
    return float(np.sqrt(np.mean(np.concatenate([v.ravel() for v in values]) ** 2)))


def closed_loop(machine: Machine, runs: Sequence[RunData], fits: dict[str, Fit]) -> dict[str, Any]:
    """Whole-loop simulation beside the log: rms differences of command and position, by model.

    The controller runs on the model instead of on the log. Differences are relative to the rms of the
    measured command and in position units; None where a simulation diverges.
    """
    result: dict[str, Any] = {}
    for name, fit in fits.items():
        command_error, position_error = [], []
        for run in runs:
            plant = fit.hypothesis.plant(machine, fit.by_key(), run.start)
            position, command = simulate(run, plant)
            command_error.append((command - run.command)[run.window])
            position_error.append((position - run.position)[run.window])
        if not all(np.all(np.isfinite(e)) for e in command_error):
            result[name] = None
            continue
        size = _rms_of([run.command[run.window] for run in runs])
        result[name] = {
            "relative_command_error": _rms_of(command_error) / size,
            f"position_error_{machine.position_unit}": _rms_of(position_error),
        }
    return result


def simulate(run: RunData, plant: FinishedPlant) -> tuple[Array, Array]:
    """Position and command (samples, n) of the closed loop on the run's reference.

    The loop closes over an exact encoder: a plant with a sensor scale gives NaN.
    """
    position = np.empty_like(run.position)
    position[0] = run.position[0]
    command, delivered = np.empty_like(position), np.empty_like(position)
    if plant.sensor_scale is not None:
        return np.full_like(position, np.nan), np.full_like(position, np.nan)
    drive_kernels.simulate(
        run.reference,
        run.reference_acceleration,
        plant.drive,
        run.controller,
        run.dt,
        plant.substeps,
        run.lsb,
        drive_kernels.initial_memory(run.controller, run.position[0]),
        position,
        command,
        delivered,
    )
    return position, command
