"""Closed loops of the benchmark for a fit: nine tests, RMS metrics, a few milliseconds.

The sampled controllers believe the nominal model, as they did on the machine (the 5 % model error of
section 5.1.2 was introduced in simulation only). Encoders are exact here, since a fit stalls on
quantisers; their rounding is added to the metrics in quadrature. One cycle counts, after half a cycle
from rest.
"""

from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from os import cpu_count

import numpy as np

from ....models import benchmark, c_drive, drive_kernels, motion
from ....models.benchmark import BenchmarkRun, Conditions
from ....models.c_drive import CDriveParameters
from ....models.motion import C_DRIVE_MOTIONS
from ..drive_machine import FinishedPlant
from ..machine import Array
from .experiment import METRICS, TESTS, quantisation

LEAD_IN = 0.5  # cycles before the one that counts
DIVERGED = 1e3  # metric, in its unit, of a loop that diverges: far above any


class BenchmarkLoops:
    """The nine tests at one rate; ``metrics`` simulates them on plants."""

    def __init__(self, rate: float, parameters: CDriveParameters | None = None) -> None:
        nominal = parameters or CDriveParameters()
        self._conditions = Conditions(rate=rate, lsb=0.0, lead=nominal.lead)
        controllers = benchmark.sampled_controllers(nominal, model_factor=1.0)
        lead_in = round(LEAD_IN * self._conditions.samples_per_cycle)
        self._kept = slice(lead_in, None)
        time = self._conditions.dt * np.arange(lead_in + self._conditions.samples_per_cycle)
        programs = {
            name: motion.c_drive_motion(name, rate).sample(time) for name in C_DRIVE_MOTIONS
        }
        self._tests = [(controllers[name], *programs[program][::2]) for name, program in TESTS]
        self._rounding = quantisation()
        self._pool = ThreadPoolExecutor(max_workers=cpu_count() or 1)
        self.simulations = 0

    def metrics(self, plants: Iterable[FinishedPlant]) -> Array:
        """RMS metrics (plants, 9, 3) as the encoders and the controller would report them."""
        plants = list(plants)
        tasks = [(plant, test) for plant in plants for test in range(len(TESTS))]
        self.simulations += len(tasks)
        found = np.array(list(self._pool.map(self._measure, tasks)))
        return found.reshape(len(plants), len(TESTS), len(METRICS))

    def _measure(self, task: tuple[FinishedPlant, int]) -> Sequence[float]:
        with np.errstate(over="ignore", invalid="ignore"):
            values = benchmark.metrics(self._run(*task))
        found = np.array([values[name] for name in METRICS])
        if not np.all(np.isfinite(found)):
            return [DIVERGED] * len(METRICS)
        return list(np.hypot(np.minimum(found, DIVERGED), self._rounding))

    def _run(self, plant: FinishedPlant, test: int) -> BenchmarkRun:
        controller, reference, acceleration = self._tests[test]
        c = self._conditions
        position, command = np.zeros_like(reference), np.zeros_like(reference)
        memory = drive_kernels.initial_memory(controller, position[0])
        drive_kernels.simulate(
            reference, acceleration, plant.drive, controller, c.dt, plant.substeps, c.lsb,
            memory, position, command, np.zeros_like(reference),
        )  # fmt: skip
        return BenchmarkRun(
            time=np.arange(c.samples_per_cycle, dtype=np.float64) * c.dt,
            reference=c_drive.collar_pose(reference[self._kept], c.lead),
            error=c_drive.collar_pose((reference - position)[self._kept], c.lead),
            torque=command[self._kept],
            cycles=1,
        )
