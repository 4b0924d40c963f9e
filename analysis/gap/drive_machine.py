"""Machines that are one drive with constant inertia: C-drive, slider.

They are predicted by ``drive_kernels.predict``: the drive runs on the logged command and says where
the encoders will be one sample later, corrected by a fixed-gain observer.
"""

from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...models import drive_kernels
from ...models.drive import Drive
from . import batches
from . import floor as floors
from .machine import Array, Machine, RunData, starts_in_motion

if TYPE_CHECKING:
    from .clock import ReplayCheck
    from .effects import Form, Scan
    from .inverse_model import Structure
    from .signals import SignalFinding


FORGOTTEN = 15.0  # time constants of the correction after which a first speed leaves nothing in the residual


@dataclass
class DrivePlant:
    """The drive that effects act on; its inverse inertia is taken after all of them have acted."""

    inertia: Array  # (shafts, shafts)
    drive: Drive
    substeps: int = 1
    time: float = 0.0  # how long the machine has been running [s]
    sensor_scale: Array | None = None  # (n,) reading per true position, None for exact encoders
    first_sensed: int = 0  # number of the first of the n shafts whose encoders are read

    def finished(self) -> "FinishedPlant":
        """The plant as the kernels need it."""
        inverse = np.ascontiguousarray(np.linalg.inv(self.inertia))
        drive = self.drive._replace(inertia_inverse=inverse)
        return FinishedPlant(drive, self.substeps, self.sensor_scale, self.first_sensed)


class FinishedPlant(NamedTuple):
    """A drive whose effects have all acted."""

    drive: Drive
    substeps: int  # integration steps per sample
    sensor_scale: Array | None
    first_sensed: int


@dataclass(frozen=True, kw_only=True)
class PayloadAxis:
    """One way a wrong or added mass shows: the inertia matrix of one unit of it."""

    name: str  # parameter name, such as collar_mass
    unit: str
    inertia: Array  # (n, n) per unit
    own: str  # the machine's own parameter it stands in for
    scale: float


@dataclass(frozen=True, kw_only=True)
class DriveMachine(Machine):
    """Nominal model of a machine whose drive the kernels can run.

    ``plant`` maps the own parameters' values, by name, to a fresh plant.
    """

    elements: tuple[str, ...]  # friction elements; the first n are the joints' own bearings
    task: tuple[str, ...]  # task coordinates
    task_map: Array  # (len(task), n), per joint position
    payload: tuple[PayloadAxis, ...]
    viscous_own: tuple[str, ...]  # own parameters that are viscous friction
    ripples: Mapping[str, float]  # spatial frequencies [1/position unit] by the name of a period
    motor_share: float  # share of the smallest inertia that sits on the motor's side
    bandwidth: float  # of the prediction's correction [rad/s]
    plant: Callable[[Mapping[str, float]], DrivePlant]
    load_encoders: bool = False  # whether the encoders may sit behind the transmission

    def build(self, values: Mapping[str, float]) -> DrivePlant:
        """A fresh plant at the own parameters' values."""
        return self.plant(values)

    def predict(self, run: RunData, plant: FinishedPlant) -> Array:
        """Prediction error (samples, n) of the encoders over the run's window [position unit]."""
        scale = 1.0 if plant.sensor_scale is None else plant.sensor_scale
        residual = np.empty_like(run.position)
        drive_kernels.predict(
            run.position / scale,
            run.command,
            plant.drive,
            run.dt,
            plant.substeps,
            self.bandwidth,
            residual,
            plant.first_sensed,
        )
        return np.asarray((residual * scale)[run.window])

    def predict_all(
        self, tasks: Sequence[tuple[RunData, Any]], submit: Callable[..., Future[Any]]
    ) -> list[Array]:
        """``predict`` of every run and plant, those of one structure side by side."""
        return batches.predict_all(self, tasks, submit)

    def forms(self, runs: Sequence[RunData]) -> "list[Form]":
        """All forms of the catalogue, scaled to the runs."""
        from .effects import forms_for, scales_of  # effects name this class

        return forms_for(self, scales_of(runs))

    def scans(self, runs: Sequence[RunData]) -> "list[Scan]":
        """Shapes of the catalogue's effects."""
        from .effects import scales_of, scans_for

        return scans_for(self, scales_of(runs))

    @property
    def designable(self) -> bool:
        """Fourier motions of the joints."""
        return True

    @property
    def task_rows(self) -> tuple[tuple[str, ...], Array]:
        """Task coordinates, with rows of length one: they weigh like the joints they are made of."""
        return self.task, self.task_map / np.linalg.norm(self.task_map, axis=1, keepdims=True)

    def unexplained(self, residual: Array, run: RunData) -> Array:
        """Effort (k, n) that would cause a prediction error (k, n).

        In steady state a constant effort d moves the prediction by M^-1 d dt / beta, with beta the
        speed gain of the prediction's correction.
        """
        _, beta = drive_kernels.correction_gains(self.bandwidth, run.dt)
        inertia = self.build(self.nominal()).inertia
        return np.asarray(residual @ inertia.T * (beta / run.dt))

    def floor(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> tuple[list[Array], str]:
        """Cycle-to-cycle repeatability, never below what the encoder's resolution does."""
        return floors.noise_floor(runs, residuals, self.bandwidth)

    def settling(self, run: RunData) -> int:
        """Predictions start from rest; the correction forgets another first speed after a while."""
        forgotten = int(np.ceil(FORGOTTEN / (self.bandwidth * run.dt)))
        return forgotten if starts_in_motion(run) else 0

    def out_of_step(self, runs: Sequence[RunData], residuals: Sequence[Array]) -> float | None:
        """What does not repeat, over the encoder's noise."""
        return floors.out_of_step(runs, residuals, self.bandwidth)

    def examine(
        self, runs: Sequence[RunData], stated_step: float | None
    ) -> "tuple[list[RunData], list[SignalFinding]]":
        """Wrong signals are found by replaying the stated controller."""
        from .signals import examine  # it fits this class

        return examine(self, runs, stated_step)

    def replays(self, runs: Sequence[RunData]) -> "list[ReplayCheck]":
        """Every run's logged command beside the stated controller's."""
        from .clock import check_replay

        return [check_replay(run) for run in runs]

    def simulate(self, run: RunData, plant: FinishedPlant) -> tuple[Array, Array]:
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
            plant.first_sensed,
        )
        return position, command

    def inverse_model(self, runs: Sequence[RunData]) -> "list[Structure]":
        """Regression of the logged effort on the terms of the equation of motion."""
        from .inverse_model import inverse_model

        return inverse_model(self, runs)

    def unit(self, quantity: str) -> str:
        """Unit of a quantity: effort, rate, viscous, inertia or stiffness."""
        angle, effort = self.position_unit, self.effort_unit
        units = {
            "position": angle,
            "effort": effort,
            "rate": f"{angle}/s",
            "viscous": f"{effort} s/{angle}",
            "stiffness": f"{effort}/{angle}",
        }
        return units[quantity]
