"""Where the gap lies: shares of its energy by signal, joint, task coordinate, regime and frequency.

The gap is the unexplained effort of the retuned nominal model: the prediction error turned into the
torque or force that would cause it. Shares of one list sum to 1.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.signal import csd, welch

from . import bootstrap
from .machine import Array, Machine, RunData
from .regimes import SORTINGS, Sorting, since_reversal

BANDS_HZ = (0.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, np.inf)
BANDS: tuple[dict[str, Any], ...] = tuple(
    {
        "name": f"{low:g}-{high:g} Hz" if np.isfinite(high) else f"above {low:g} Hz",
        "low_Hz": low,
        "high_Hz": high if np.isfinite(high) else None,
    }
    for low, high in pairwise(BANDS_HZ)
)
REGIMES = ("at rest", "after reversal", "slow", "fast", "accelerating", "braking")
AFTER_REVERSAL = 0.02  # s
RESAMPLES = 400
BLOCKS = 20  # per run
SEGMENT = 512  # samples of a spectrum's segment


def locate(
    runs: Sequence[RunData], residuals: Sequence[Array], machine: Machine, seed: int
) -> dict[str, list[dict[str, Any]]]:
    """Shares of the gap as in FORMAT.md, each list summing to 1."""
    efforts = [machine.unexplained(r, run) for run, r in zip(runs, residuals)]
    rng = np.random.default_rng(seed)
    joints = shares(machine.joints, [e**2 for e in efforts], rng)
    names, rows = machine.task_rows
    task = shares(names, [(e @ rows.T) ** 2 for e in efforts], rng)
    signals = shares([f"{s} position" for s in machine.joints], [r**2 for r in residuals], rng)
    by_regime = _by_regime(runs, efforts)
    by_band = _by_band(runs, efforts)
    return {
        "signals": signals,
        "joints": joints,
        "task": task,
        "regimes": shares(REGIMES, [e.sum(axis=1) for e in by_regime], rng),
        "bands": [
            {**band, "share": float(share), "coherence": coherence}
            for band, share, coherence in zip(BANDS, by_band.sum(axis=0), _coherence(runs, efforts))
        ],
        "harmonics": _harmonics(runs, efforts, rng),
        **{s.key: _sorted(s, runs, efforts, rng) for s in SORTINGS},
        "runs": of_runs(runs, efforts),
        "joint_regimes": _table(
            "regime", machine.joints, REGIMES, np.sum([e.sum(axis=0) for e in by_regime], axis=0)
        ),
        "joint_bands": _table("band", machine.joints, [b["name"] for b in BANDS], by_band),
    }


def _by_regime(runs: Sequence[RunData], efforts: Sequence[Array]) -> list[Array]:
    """Energies (samples, joints, regimes) of exclusive regimes of each joint's reference."""
    peak = max(float(np.max(np.abs(run.reference_rate))) for run in runs) or 1.0
    energies = []
    for run, effort in zip(runs, efforts):
        rate = run.reference_rate[run.window]
        acceleration = run.reference_acceleration[run.window]
        rest = np.abs(rate) < 1e-3 * peak
        turned = since_reversal(rate, run.dt) < AFTER_REVERSAL
        power = rate * acceleration
        strong = np.abs(acceleration) > 0.5 * np.max(np.abs(acceleration), axis=0, initial=1e-12)
        masks = [rest, turned & ~rest]
        moving = ~rest & ~turned
        masks += [moving & ~strong & (np.abs(rate) < 0.3 * peak)]
        masks += [moving & ~strong & (np.abs(rate) >= 0.3 * peak)]
        masks += [moving & strong & (power >= 0.0), moving & strong & (power < 0.0)]
        energies.append(np.stack([mask * effort**2 for mask in masks], axis=2))
    return energies


def _sorted(
    sorting: Sorting, runs: Sequence[RunData], efforts: Sequence[Array], rng: Any
) -> list[dict[str, Any]]:
    """Shares by one way of sorting samples; empty where its signal has other columns than the joints."""
    energies = []
    for run, effort in zip(runs, efforts):
        labels = sorting.labels(runs, run)[run.window]
        if labels.shape != effort.shape:
            return []
        columns = [
            np.sum(np.where(labels == k, effort**2, 0.0), axis=1) for k in range(len(sorting.names))
        ]
        energies.append(np.column_stack(columns))
    return shares(sorting.names, energies, rng)


def _harmonics(runs: Sequence[RunData], efforts: Sequence[Array], rng: Any) -> list[dict[str, Any]]:
    """Shares of what repeats with the cycle and what does not, over runs of two cycles and more."""
    energies = []
    for run, effort in zip(runs, efforts):
        cycles = len(effort) // run.period if run.period else 0
        if run.period is None or cycles < 2:
            continue
        stack = effort[: cycles * run.period].reshape(cycles, run.period, -1)
        mean = stack.mean(axis=0, keepdims=True)
        between = _in_blocks(((stack - mean) ** 2).sum(axis=(0, 2))) * cycles / (cycles - 1)
        every = _in_blocks((stack**2).sum(axis=(0, 2)))
        energies.append(np.column_stack([np.maximum(every - between, 0.0), between]))
    names = ("at harmonics of the cycle", "between them")
    return shares(names, energies, rng) if energies else []


def _in_blocks(values: Array) -> Array:
    """Sums (blocks,) of values (samples,)."""
    return np.array([block.sum() for block in np.array_split(values, BLOCKS)])


def _coherence(runs: Sequence[RunData], efforts: Sequence[Array]) -> list[float]:
    """Mean coherence (bands,) of the effort with its joint's reference speed, weighted by energy."""
    weight, total = np.zeros(len(BANDS)), np.zeros(len(BANDS))
    for run, effort in zip(runs, efforts):
        segment = min(SEGMENT, len(effort) // 2)
        if segment < 8:
            continue
        for j, column in enumerate(effort.T):
            rate = run.reference_rate[run.window][:, j]
            if np.ptp(rate) == 0.0 or np.ptp(column) == 0.0:
                continue
            frequency, power = welch(column, 1.0 / run.dt, nperseg=segment)
            _, cross = csd(rate, column, 1.0 / run.dt, nperseg=segment)
            _, drive = welch(rate, 1.0 / run.dt, nperseg=segment)
            seen = np.abs(cross) ** 2 / np.maximum(drive, 1e-12 * drive.max())
            weight += np.histogram(frequency, BANDS_HZ, weights=seen)[0]
            total += np.histogram(frequency, BANDS_HZ, weights=power)[0]
    return [float(w / t) if t > 0.0 else 0.0 for w, t in zip(weight, total)]


def _by_band(runs: Sequence[RunData], efforts: Sequence[Array]) -> Array:
    """Shares (joints, bands) of the energy of all runs."""
    energy = np.zeros((efforts[0].shape[1], len(BANDS)))
    for run, effort in zip(runs, efforts):
        spectrum = np.abs(np.fft.rfft(effort, axis=0)) ** 2 / len(effort)
        spectrum[1:] *= 2.0
        frequency = np.fft.rfftfreq(len(effort), run.dt)
        for j, column in enumerate(spectrum.T):
            energy[j] += np.histogram(frequency, BANDS_HZ, weights=column)[0]
    return energy / (energy.sum() or 1.0)


def _table(
    across: str, joints: Sequence[str], names: Sequence[str], energy: Array
) -> list[dict[str, Any]]:
    """Shares of energies (joints, names), one entry a cell."""
    cells = energy / (energy.sum() or 1.0)
    return [
        {"joint": joint, across: name, "share": float(share)}
        for joint, row in zip(joints, cells)
        for name, share in zip(names, row)
    ]


def of_runs(runs: Sequence[RunData], efforts: Sequence[Array]) -> list[dict[str, Any]]:
    """Share of every run."""
    energy = np.array([np.sum(e**2) for e in efforts])
    return [
        {"name": run.name, "share": float(e / (energy.sum() or 1.0))}
        for run, e in zip(runs, energy)
    ]


def shares(names: Sequence[str], energies: Sequence[Array], rng: Any) -> list[dict[str, Any]]:
    """Shares of columns of energies (samples, names), with block-bootstrap intervals."""
    blocks = np.array([b.sum(axis=0) for e in energies for b in np.array_split(e, BLOCKS, axis=0)])
    totals = blocks.sum(axis=0)
    sums = blocks[bootstrap.draws(len(blocks), RESAMPLES, rng)].sum(axis=1)
    low, high = bootstrap.interval(sums / np.maximum(sums.sum(axis=1, keepdims=True), 1e-300))
    return [
        {"name": name, "share": float(s), "ci95": [float(a), float(b)]}
        for name, s, a, b in zip(names, totals / (totals.sum() or 1.0), low, high)
    ]
