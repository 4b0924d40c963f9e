"""The C-drive benchmark: the metrics of Friedlaender 2015, section 5.1.4, from simulated closed loops.

A motion is repeated without pause and the first cycle is left out. Errors are what the encoder measures,
mapped to the collar by J (2.1b). Two kinds of controller can be simulated, told apart by their type:
``LoopController``, sampled, as on a real machine (``drive_kernels``), and ``BlockController``, continuous
blocks under ODE4, as in the thesis's simulation (``block_loop``).
"""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from . import c_drive, drive, drive_kernels, encoder, motion, thesis_tables
from .block_loop import BlockController, Wiring, simulate_blocks
from .c_drive import CDriveParameters
from .c_drive_controllers import PD, ComputedTorque, TaskSpacePD, loop_controller
from .drive import Drive
from .drive_kernels import LoopController
from .observer import ContinuousObserver, continuous_observer
from .thesis_tables import Key

Settings = PD | TaskSpacePD | ComputedTorque
SETTINGS: dict[str, Settings] = {"pd": PD(), "ct": ComputedTorque(), "ts": TaskSpacePD()}
LSB = encoder.resolution(13)  # of the motor encoders [rad]


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """How the benchmark is run; ValueError if a cycle is not a whole, even number of samples."""

    rate: float = 2.0  # cycles per second [Hz]
    cycles: int = 6  # simulated, the first of which is left out
    dt: float = 1e-3  # step and sample time [s]
    substeps: int = 1  # integration steps a sample, more for a flexible plant; sampled loop only
    lsb: float = LSB  # encoder step of sampled controllers [rad]; block controllers have their own
    lead: float = 0.060  # p_c [m/rev]

    def __post_init__(self) -> None:
        samples = 1.0 / (self.rate * self.dt)
        if abs(samples - round(samples)) > 1e-6 or round(samples) % 2:
            raise ValueError(
                f"rate {self.rate} Hz at dt {self.dt} s gives {samples:g} samples a cycle; "
                "expected an even whole number"
            )
        if self.cycles < 2:
            raise ValueError(f"cycles is {self.cycles}; expected 2 or more, the first is left out")

    @property
    def samples_per_cycle(self) -> int:
        """Samples of one cycle."""
        return round(1.0 / (self.rate * self.dt))


@dataclass(frozen=True, kw_only=True)
class BenchmarkRun:
    """Steady cycles of one simulated test, (samples, 2) each, the first cycle left out."""

    time: NDArray[np.float64]  # (samples,) [s], zero at the start of the first kept cycle
    reference: NDArray[np.float64]  # collar (u [m], theta [rad])
    error: NDArray[np.float64]  # measured collar error (u [m], theta [rad])
    torque: NDArray[np.float64]  # commanded motor torques (left, right) [N m]
    cycles: int  # kept


def block_controller(
    settings: Settings, model: CDriveParameters, wiring: Wiring
) -> BlockController:
    """The controller as continuous blocks; ``model`` is the drive as the controller believes it to be."""
    gains = loop_controller(settings, model, 1e-3)
    if isinstance(settings, ComputedTorque):
        observer = continuous_observer(model, settings.poles)
    else:
        observer = ContinuousObserver(*[np.zeros((2, 2))] * 5)
    return BlockController(gains, observer, wiring)


def thesis_controllers(
    drive_parameters: CDriveParameters,
    *,
    model_factor: float = 0.95,
    dead_zone_counts: float = 1.0,
) -> dict[str, BlockController]:
    """PD, CT and TS as the thesis simulated them, by the setting that reproduces its Table 5-4.

    The model error of 5 % is taken off M and D, and the servo laws do not see errors within one
    encoder count. The thesis prints neither the sign of the one nor the other: both are inferred
    from its tables (``gapscope compare ct-errors``).
    """
    wiring = Wiring(lsb=LSB, dead_zone=dead_zone_counts * LSB)
    return {
        name: block_controller(settings, drive_parameters.scaled_model(model_factor), wiring)
        for name, settings in SETTINGS.items()
    }


def sampled_controllers(
    drive_parameters: CDriveParameters, *, model_factor: float = 1.05, dt: float = 1e-3
) -> dict[str, LoopController]:
    """PD, CT and TS as sampled controllers without dead zone."""
    model = drive_parameters.scaled_model(model_factor)
    return {name: loop_controller(settings, model, dt) for name, settings in SETTINGS.items()}


def benchmark_run(
    plant: Drive,
    controller: LoopController | BlockController,
    motion_name: str,
    conditions: Conditions,
) -> BenchmarkRun:
    """Simulate one test.

    Raises ValueError for an unknown motion, or for a block controller on a plant with command delay,
    torque lag, presliding or couplings, which that loop does not model.
    """
    program = motion.c_drive_motion(motion_name, conditions.rate)
    per_cycle, dt = conditions.samples_per_cycle, conditions.dt
    samples = per_cycle * conditions.cycles
    position, command = np.zeros((samples, 2)), np.zeros((samples, 2))
    if isinstance(controller, BlockController):
        _refuse_sampled_effects(plant)
        halves = program.sample(0.5 * dt * np.arange(2 * samples + 1))
        simulate_blocks(*halves, plant, controller, dt, position, command)
        reference = halves[0][:-1:2]
    else:
        reference, _, acceleration = program.sample(dt * np.arange(samples))
        drive_kernels.simulate(
            reference,
            acceleration,
            plant,
            controller,
            dt,
            conditions.substeps,
            conditions.lsb,
            drive_kernels.initial_memory(controller, position[0]),
            position,
            command,
            np.zeros((samples, 2)),
        )
    kept = slice(per_cycle, None)
    return BenchmarkRun(
        time=np.arange(samples - per_cycle, dtype=np.float64) * dt,
        reference=c_drive.collar_pose(reference[kept], conditions.lead),
        error=c_drive.collar_pose(reference[kept] - position[kept], conditions.lead),
        torque=command[kept],
        cycles=conditions.cycles - 1,
    )


def metrics(run: BenchmarkRun) -> dict[str, float]:
    """The metrics of section 5.1.4 by their names in ``thesis_tables``.

    Endpoint errors are signed, at the start of each cycle, where the motion has just come back.
    """
    rms_torque = np.sqrt(np.mean(run.torque**2, axis=0))
    rms_u, rms_theta = np.sqrt(np.mean(run.error**2, axis=0))
    by_cycle = np.abs(run.error).reshape(run.cycles, -1, 2)
    max_u, max_theta = by_cycle.max(axis=1).mean(axis=0)
    end_u, end_theta = run.error.reshape(run.cycles, -1, 2)[:, 0].mean(axis=0)
    peak = np.abs(run.torque).reshape(run.cycles, -1, 2).max(axis=1).mean(axis=0)
    return {
        thesis_tables.TAU_RMS: float(rms_torque.mean()),
        thesis_tables.E_U_RMS: 1e3 * float(rms_u),
        thesis_tables.E_THETA_RMS: float(rms_theta),
        thesis_tables.E_U_END: 1e3 * float(end_u),
        thesis_tables.E_THETA_END: float(end_theta),
        thesis_tables.TAU_MAX: float(peak.max()),
        thesis_tables.E_U_MAX: 1e3 * float(max_u),
        thesis_tables.E_THETA_MAX: float(max_theta),
    }


def benchmark_metrics(
    plant: Drive,
    controllers: Mapping[str, LoopController] | Mapping[str, BlockController],
    conditions: Conditions | None = None,
    motions: Iterable[str] = thesis_tables.MOTIONS,
) -> dict[Key, float]:
    """All metrics by (controller, motion, metric), as ``PrintedRow.key`` names them.

    About 4 ms a test of six sampled cycles and 8 ms as blocks; in a fit, fewer cycles do. A loop that
    diverges gives non-finite values. Raises ValueError as ``benchmark_run`` does.
    """
    conditions = conditions or Conditions()
    return {
        (name, motion_name, metric): value
        for name, controller in controllers.items()
        for motion_name in motions
        for metric, value in metrics(
            benchmark_run(plant, controller, motion_name, conditions)
        ).items()
    }


def _refuse_sampled_effects(plant: Drive) -> None:
    sampled_only = (
        plant.shaft[:, (drive.DELAY, drive.LAG)],
        plant.element[:, drive.STIFFNESS],
        plant.coupling,
    )
    if any(np.any(constants) for constants in sampled_only):
        raise ValueError(
            "the block loop has no command delay, torque lag, presliding or couplings; "
            "use sampled controllers"
        )
