"""Group ``monte-carlo``: tracking errors of the C-drive's closed loop for many sets of parameters.

The loop of ``closed-loop`` with exact encoders; every set scales inertia and friction of the drive. One run
takes all sets, on all cores. Only the errors are kept, so memory does not grow with the samples.
"""

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...diagrams.c_drive_config import CDriveLoopConfig
from ...diagrams.c_drive_loop import actuated_drive
from ...models import drive_kernels
from ...models.c_drive_controllers import loop_controller
from . import closed_loop, jax_batch
from .c_loop import NoCompilerError, c_batch
from .peer_laws import Constants
from .rounds import Contender, Group, Skipped, measure, rows

NAME = "monte-carlo"
SETS, QUICK_SETS = 20_000, 1_000
CHUNK = 250  # sets that a thread takes at once
SEED = 8
SPREAD = (0.5, 1.5)  # factors of inertia and friction, uniform
FIELDS = ("m11", "m12", "beta", "gamma", "delta", "eta")
TOLERANCE = 1e-9  # of the largest error; vectorised tanh is good to a few units in the last place
OURS, C, JAX = "gapscope, threads over chunks", "C, SIMD and OpenMP", "JAX vmap"

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
    found, skipped = [Contender(name=OURS, run=_ours(config, table, samples))], []
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
    """``drive_kernels.simulate`` for each set, without the GIL, a chunk of sets to a thread at a time."""
    dt = config.sample_time
    reference, _, acceleration = config.program().sample(dt * np.arange(samples))
    controller = loop_controller(config.controller.settings(), config.believed(), dt)

    def chunk(values: NDArray[np.float64]) -> Errors:
        position, command, delivered = (np.zeros((samples, 2)) for _ in range(3))
        errors = np.empty(len(values))
        for j, row in enumerate(values.tolist()):
            machine = replace(config.machine, **dict(zip(FIELDS, row)))
            plant: Any = actuated_drive(replace(config, machine=machine))
            position[0] = 0.0
            memory = drive_kernels.initial_memory(controller, position[0])
            drive_kernels.simulate(
                reference, acceleration, plant, controller, dt, 1, 0.0,
                memory, position, command, delivered,
            )  # fmt: skip
            errors[j] = np.sqrt(np.mean((reference - position) ** 2))
        return errors

    def run() -> Errors:
        chunks = [table[first : first + CHUNK] for first in range(0, len(table), CHUNK)]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return np.concatenate(list(pool.map(chunk, chunks)))

    return run
