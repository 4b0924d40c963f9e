"""Closed-chain machines driven through gears: five-bar, tables on three legs.

A drive whose inertia changes with posture: tables of the machine's terms along the measured motion stand beside
the drive, ``models.chain_kernels``. Everything counts in the motors' coordinates, angles in rad and torques in N m.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...models import chain_kernels, drive_kernels
from ...models.chain_kernels import Tables
from ...models.drive import Drive
from ...models.parallel.machine import ParallelMachine, Part
from .drive_machine import DriveMachine, DrivePlant
from .machine import Array, Machine, RunData

if TYPE_CHECKING:
    from .clock import ReplayCheck
    from .effects import Form, Scan
    from .inverse_model import Structure
    from .signals import SignalFinding


@dataclass(frozen=True, kw_only=True)
class ChainRun(RunData):
    """A run with the machine's terms along it."""

    tables: Tables


@dataclass
class ChainPlant(DrivePlant):
    """A drive, and how much of each part of the machine it moves: 1 of the whole, kilograms of the others."""

    weights: Array = field(default_factory=lambda: np.ones(1))  # (parts,)

    def finished(self) -> "FinishedChain":  # type: ignore[override]
        """The plant as the kernel needs it."""
        inertia = np.ascontiguousarray(self.inertia)
        return FinishedChain(self.drive, inertia, self.weights, self.substeps, self.sensor_scale)


class FinishedChain(NamedTuple):
    """A chain whose effects have all acted."""

    drive: Drive
    inertia: Array  # of the axes alone (shafts, shafts) [kg m^2]
    weights: Array
    substeps: int  # integration steps per sample
    sensor_scale: Array | None


@dataclass(frozen=True, kw_only=True)
class ChainMachine(DriveMachine):
    """Nominal model of a closed chain; joint motion is ``per_motor`` of the motors'."""

    chain: ParallelMachine
    per_motor: float  # i_R [rad/rad or m/rad]

    def predict(self, run: RunData, plant: FinishedChain) -> Array:  # type: ignore[override]
        """Prediction error (samples, n) of the motors' encoders over the run's window [rad]."""
        assert isinstance(run, ChainRun)
        scale = 1.0 if plant.sensor_scale is None else plant.sensor_scale
        residual = np.empty_like(run.position)
        chain_kernels.predict(
            run.position / scale,
            run.command,
            run.tables,
            plant.weights,
            plant.inertia,
            plant.drive,
            run.dt,
            plant.substeps,
            self.bandwidth,
            residual,
        )
        return np.asarray((residual * scale)[run.window])

    def forms(self, runs: Sequence[RunData]) -> "list[Form]":
        """The catalogue's forms for a drive, with the parts of this machine as payloads."""
        from .chain_payload import forms as payload
        from .effects import forms_for, scales_of  # effects name the drive's class

        drive = [f for f in forms_for(self, scales_of(runs)) if f.effect != "inertia.payload"]
        return [*drive, *payload(self)]

    def predict_all(
        self, tasks: Sequence[tuple[RunData, Any]], submit: Callable[..., Future[Any]]
    ) -> list[Array]:
        """One after the other: the lanes hold drives with constant inertia."""
        return Machine.predict_all(self, tasks, submit)

    def scans(self, runs: Sequence[RunData]) -> "list[Scan]":
        """None: a prediction is dear here, and the listed periods are tried instead."""
        return []

    def unexplained(self, residual: Array, run: RunData) -> Array:
        """Torque (k, n) at the motors that would cause a prediction error (k, n), in the mean posture."""
        assert isinstance(run, ChainRun)
        _, beta = drive_kernels.correction_gains(self.bandwidth, run.dt)
        plant = self.build(self.nominal())
        assert isinstance(plant, ChainPlant)
        machine = np.einsum("p,spij->ij", plant.weights, run.tables.inertia) / len(run.t)
        return np.asarray(residual @ (plant.inertia + machine).T * (beta / run.dt))

    def examine(
        self, runs: Sequence[RunData], stated_step: float | None
    ) -> "tuple[list[RunData], list[SignalFinding]]":
        """No control law is stated that could tell wrong signals."""
        return list(runs), []

    def replays(self, runs: Sequence[RunData]) -> "list[ReplayCheck]":
        """No control law is replayed."""
        return []

    def simulate(self, run: RunData, plant: FinishedChain) -> None:  # type: ignore[override]
        """No loop is simulated."""
        return None

    def inverse_model(self, runs: Sequence[RunData]) -> "list[Structure]":
        """No regression: inertia changes with posture."""
        return []


def tables(chain: ParallelMachine, joints: Array, per_motor: float) -> Tables:
    """Terms of the parts of a machine along joint positions (samples, n), on the motors' shafts.

    Velocity terms are quadratic in the rates: their coefficients come from unit rates by polarisation.
    """
    parts = list(chain.parts().values())
    found = [_part(part, np.asarray(joints, dtype=float)) for part in parts]
    inertia, velocity, gravity = (np.stack(term, axis=1) for term in zip(*found))
    r = per_motor
    return Tables(
        *(np.ascontiguousarray(t) for t in (r**2 * inertia, r**3 * velocity, r * gravity))
    )


def _part(part: Part, q: Array) -> tuple[Array, Array, Array]:
    n = q.shape[1]
    unit = np.broadcast_to(np.eye(n)[:, None, :], (n, *q.shape))
    alone = [part.equations(q, unit[j]) for j in range(n)]
    h = np.zeros((len(q), n, n, n))
    for j in range(n):
        h[:, :, j, j] = alone[j].velocity
    for j, k in combinations(range(n), 2):
        both = part.equations(q, unit[j] + unit[k]).velocity
        h[:, :, j, k] = h[:, :, k, j] = 0.5 * (both - alone[j].velocity - alone[k].velocity)
    return alone[0].inertia, h, alone[0].gravity


def chain_plant(
    values: Mapping[str, float], drive: Drive, parts: Sequence[str], joints: Sequence[str]
) -> ChainPlant:
    """Plant of equal axes: ``rotor_inertia`` and, for each joint, ``viscous_`` of the values."""
    from ...models.drive import VISCOUS

    plant = ChainPlant(inertia=values["rotor_inertia"] * np.eye(len(joints)), drive=drive.copy())
    plant.drive.element[:, VISCOUS] = [values[f"viscous_{joint}"] for joint in joints]
    plant.weights = np.array([1.0] + [0.0] * (len(parts) - 1))
    plant.weights[0] = values["machine_inertia"]
    return plant
