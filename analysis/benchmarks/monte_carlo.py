"""Group ``monte-carlo``: tracking errors of the C-drive's closed loop for many sets of parameters.

The loop of ``closed-loop`` with exact encoders; every set scales inertia and friction of the drive. One run
takes all sets, on all cores. Only the errors are kept, so memory does not grow with the samples.
"""

import os
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ...diagrams.c_drive_config import CDriveLoopConfig
from ...diagrams.c_drive_loop import actuated_drive
from ...models import drive, drive_batch
from ...models.c_drive_controllers import loop_controller
from . import closed_loop, jax_batch
from .c_loop import NoCompilerError, c_batch
from .peer_laws import Constants
from .rounds import Contender, Group, Skipped, measure, rows

NAME = "monte-carlo"
SETS, QUICK_SETS = 20_000, 1_000
SEED = 8
SPREAD = (0.5, 1.5)  # factors of inertia and friction, uniform
FIELDS = ("m11", "m12", "beta", "gamma", "delta", "eta")
TOLERANCE = 1e-9  # of the largest error; vectorised tanh is good to a few units in the last place
OURS, C, JAX = "gapscope in lanes, threads", "C, SIMD and OpenMP", "JAX vmap"
ROLLOUT = "MuJoCo rollout"
NO_ROLLOUT = "it has neither tanh friction nor a sampled PD: each stage would call back into Python, as in closed-loop"

Errors = NDArray[np.float64]
Run = Callable[[], Errors]


def monte_carlo(rounds: int, sets: int = SETS, samples: int = closed_loop.SAMPLES) -> Group:
    """Time all contenders on ``sets`` parameter sets over ``rounds`` interleaved rounds."""
    config = replace(closed_loop.task(), encoder_bits=0)
    table = parameter_sets(config, sets)
    contenders, skipped = _contenders(config, table, samples)
    reference = C if C in [contender.name for contender in contenders] else OURS
    results = {contender.name: contender.run() for contender in contenders}
    seconds, repeats = measure(contenders, rounds)
    checks = [
        _check(results[contender.name], results[reference], float(np.median(times)))
        for contender, times in zip(contenders, seconds.T)
    ]
    return Group(
        name=NAME,
        task=f"C-drive as in closed-loop, exact encoders, {sets} parameter sets, seed {SEED}, "
        f"{samples} samples, {os.cpu_count()} cores",
        rounds=rounds,
        reference=reference,
        agreement=f"tracking error of every set within {TOLERANCE:g} of the largest, to {reference}",
        rows=rows(contenders, seconds, repeats, checks, reference),
        skipped=tuple(skipped),
    )


def parameter_sets(config: CDriveLoopConfig, sets: int) -> NDArray[np.float64]:
    """Values (sets, 6) of ``FIELDS`` in SI units; both inertias have one factor, each friction its own."""
    factors = np.random.default_rng(SEED).uniform(*SPREAD, (sets, len(FIELDS) - 1))
    nominal = np.array([getattr(config.machine, name) for name in FIELDS])
    return np.asarray(nominal * factors[:, [0, 0, 1, 2, 3, 4]])


def _check(errors: Errors, reference: Errors, seconds: float) -> tuple[str, bool]:
    found = float(np.max(np.abs(errors - reference)) / np.max(reference))
    return f"differs by {found:.1e}; {len(errors) / seconds:.0f} sets/s", found <= TOLERANCE


def _contenders(
    config: CDriveLoopConfig, table: NDArray[np.float64], samples: int
) -> tuple[list[Contender], list[Skipped]]:
    found = [Contender(name=OURS, run=_ours(config, table, samples))]
    skipped = [Skipped(name=ROLLOUT, reason=NO_ROLLOUT)]
    reference = config.program().sample(config.sample_time * np.arange(samples))[0]
    c = Constants(*closed_loop.c_constants(config).tolist())
    shared = np.array([c.width, c.kp, c.kd, c.cutoff, c.dt])
    makers: dict[str, Callable[[], Run]] = {
        JAX: lambda: jax_batch.batch(c, reference, table),
        C: lambda: c_batch(reference, table, shared),
    }
    for name, make in makers.items():
        try:
            found.append(Contender(name=name, run=make()))
        except (ImportError, NoCompilerError) as error:
            skipped.append(Skipped(name=name, reason=str(error)))
    return found, skipped


def _ours(config: CDriveLoopConfig, table: NDArray[np.float64], samples: int) -> Run:
    """``drive_batch.simulate``, and before it the drives of the table."""
    dt = config.sample_time
    reference, _, acceleration = config.program().sample(dt * np.arange(samples))
    controller = loop_controller(config.controller.settings(), config.believed(), dt)

    def run() -> Errors:
        tracking = drive_batch.simulate(
            reference, acceleration, _drives(config, table), controller, dt, 1, 0.0, np.zeros(2)
        )
        return np.asarray(np.sqrt(np.mean(tracking.error_rms**2, axis=1)))

    return run


def _drives(config: CDriveLoopConfig, table: NDArray[np.float64]) -> drive.Drive:
    """The C-drives of a table (sets, 6) of ``FIELDS``."""
    m11, m12, beta, gamma, delta, eta = table.T
    plants = drive_batch.repeated(actuated_drive(config), len(table))
    inertia = np.moveaxis(np.array([[m11, m12], [m12, m11]]), -1, 0)
    plants.inertia_inverse[:] = np.linalg.inv(inertia)
    plants.element[:, :, drive.VISCOUS] = np.stack([beta, beta, 0.5 * gamma], axis=1)
    for level in (drive.FORWARD, drive.BACKWARD):
        plants.element[:, :, level] = np.stack([delta, delta, eta], axis=1)
    return plants
