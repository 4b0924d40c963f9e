"""Inverse-dynamics regression: how much of the logged effort does each structure explain?

The logged effort is regressed on the terms of the equation of motion, measured from the logged
position by zero-phase low-pass filtering and central differences, the classical identification of
drives (Gautier and Khalil; Janot, Gautier and Brunot 2019 for EMPS). Structures grow from inertia
alone to direction-dependent friction; each is refitted and reported by its relative error
``|effort - fit| / |effort|``. A quick look beside the prediction-error fits, which decide.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.signal import butter, decimate, filtfilt

from .drive_machine import DriveMachine
from .machine import Array, RunData

CUTOFF_HZ = 300.0  # of the differentiated position; the decimation filter does the smoothing
DECIMATION = 20  # of efforts and regressors alike: noise beyond it is no part of the model
STRUCTURES = ("inertia", "viscous", "coulomb", "offset", "by direction")


@dataclass(frozen=True, kw_only=True)
class Structure:
    """One structure: the terms up to and including ``name``."""

    name: str
    relative_error: float
    parameters: dict[str, float]


def inverse_model(
    machine: DriveMachine, runs: Sequence[RunData], cutoff: float = CUTOFF_HZ
) -> list[Structure]:
    """Relative effort errors of growing structures, fitted to all the runs."""
    blocks: dict[str, list[tuple[str, Array]]] = {name: [] for name in STRUCTURES}
    effort = np.concatenate([_decimated(run.command[run.window]) for run in runs])
    motion = [_motion(run, cutoff) for run in runs]
    n = len(machine.joints)

    def add(kind: str, name: str, column: Any) -> None:
        blocks[kind].append(
            (name, np.concatenate([_decimated(column(q, v, a)) for q, v, a in motion]))
        )

    for axis in machine.payload:
        add("inertia", axis.name, lambda q, v, a, axis=axis: a @ axis.inertia.T)
    if n > 1:  # the motors' own rotors, which no payload axis covers
        add("inertia", "rotors", lambda q, v, a: a)
    E = machine.build(machine.nominal()).drive.elements
    for i, name in enumerate(machine.elements):
        e = E[i]
        add("viscous", name, lambda q, v, a, e=e: np.outer(v @ e, e))
        add("coulomb", name, lambda q, v, a, e=e: np.outer(np.sign(v @ e), e))
        add("by direction", name, lambda q, v, a, e=e: np.outer(np.abs(v @ e), e))
    for j, name in enumerate(machine.joints):
        unit = np.eye(n)[j]
        add("offset", name, lambda q, v, a, unit=unit: np.tile(unit, (len(q), 1)))
    return _grow(blocks, effort)


def _grow(blocks: dict[str, list[tuple[str, Array]]], effort: Array) -> list[Structure]:
    columns: list[tuple[str, Array]] = []
    found = []
    size = float(np.linalg.norm(effort))
    for kind in STRUCTURES:
        columns += [(f"{kind} {name}", column.ravel()) for name, column in blocks[kind]]
        matrix = np.column_stack([column for _, column in columns])
        solution, *_ = np.linalg.lstsq(matrix, effort.ravel(), rcond=None)
        error = float(np.linalg.norm(effort.ravel() - matrix @ solution)) / size
        values = {name: float(v) for (name, _), v in zip(columns, solution)}
        found.append(Structure(name=kind, relative_error=error, parameters=values))
    return found


def _motion(run: RunData, cutoff: float) -> tuple[Array, Array, Array]:
    """Low-passed position, rate and acceleration of a run's window, (samples, n) each."""
    b, a = butter(4, cutoff, fs=1.0 / run.dt)
    q = filtfilt(b, a, run.position, axis=0)
    v = np.gradient(q, run.dt, axis=0)
    return q[run.window], v[run.window], np.gradient(v, run.dt, axis=0)[run.window]


def _decimated(signal: Array) -> Array:
    return np.asarray(decimate(signal, DECIMATION, ftype="iir", axis=0, zero_phase=True))
