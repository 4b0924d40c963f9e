"""What stands beside the verdict: tables, shares, other nominal models, the next experiment, warnings."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....models import benchmark, c_drive
from ....models.benchmark import Conditions
from ....models.c_drive import CDriveParameters
from ..drive_machine import DriveMachine
from ..hypothesis import Fit
from ..machine import Array
from ..ranking import Ranked
from .evidence import Observation
from .experiment import METRICS, TESTS, Experiment, Scatter, replicate_differences
from .fitting import TableFitter
from .loops import BenchmarkLoops
from .result import Entry

OTHER_RATES = (0.5, 1.25, 2.5)  # [Hz], where a next experiment could be


def entries(
    fitters: Sequence[TableFitter], nominal: Fit, retuned: Fit, best: Fit, spread: Scatter
) -> tuple[Entry, ...]:
    """Every printed number beside the models."""
    table_entries = []
    for fitter in fitters:
        table = fitter.experiment
        models = [fitter.metrics(f) for f in (nominal, retuned, best)]
        deviation = spread.relative * spread.scale(table.measured)
        for i, (controller, motion) in enumerate(TESTS):
            for j, metric in enumerate(METRICS):
                printed = float(table.simulated[i, j])
                table_entries.append(
                    Entry(
                        controller=controller,
                        motion=motion,
                        metric=metric,
                        rate_Hz=table.rate,
                        measured=float(table.measured[i, j]),
                        deviation=float(deviation[i, j]),
                        thesis_simulation=None if np.isnan(printed) else printed,
                        nominal=float(models[0][i, j]),
                        retuned=float(models[1][i, j]),
                        best=float(models[2][i, j]),
                    )
                )
    return tuple(table_entries)


def location(errors: Array) -> dict[str, list[dict[str, Any]]]:
    """Shares of the squared relative error of the retuned nominal model at 2 Hz."""
    energy = errors**2
    total = float(energy.sum())

    def shares(values: dict[str, float]) -> list[dict[str, Any]]:
        found = [{"name": name, "share": value / total} for name, value in values.items()]
        return sorted(found, key=lambda row: -float(str(row["share"])))

    by_test = {f"{c} {m}": float(energy[i].sum()) for i, (c, m) in enumerate(TESTS)}
    regimes: dict[str, float] = {}
    controllers: dict[str, float] = {}
    for i, (controller, motion) in enumerate(TESTS):
        regimes[motion] = regimes.get(motion, 0.0) + float(energy[i].sum())
        controllers[controller] = controllers.get(controller, 0.0) + float(energy[i].sum())
    return {
        "signals": shares({m: float(energy[:, j].sum()) for j, m in enumerate(METRICS)}),
        "joints": [],
        "regimes": shares(regimes),
        "bands": [],
        "controllers": shares(controllers),
        "tests": shares(by_test),
    }


def variants(
    tables: dict[float, Experiment],
    spread: Scatter,
    fitter: TableFitter,
    held_out: TableFitter,
    nominal: Fit,
) -> dict[str, dict[str, float | None]]:
    """Relative rms errors of other simulations without any effect: does the nominal model matter?"""
    parameters = CDriveParameters()
    blocks = benchmark.thesis_controllers(parameters)
    plant = c_drive.drive(parameters)

    def rms(errors: Array) -> float:
        return float(np.sqrt(np.mean(errors**2)))

    def of_blocks(rate: float) -> float:
        found = benchmark.benchmark_metrics(plant, blocks, Conditions(rate=rate, cycles=2))
        model = np.array([[found[(*test, metric)] for metric in METRICS] for test in TESTS])
        return rms(spread.relative_error(model, tables[rate].measured))

    printed = spread.relative_error(tables[2.0].simulated, tables[2.0].measured)
    return {
        "nominal model, sampled controllers": {
            "2 Hz": rms(fitter.errors(nominal)),
            "1 Hz": rms(held_out.errors(nominal)),
        },
        "printed simulation": {"2 Hz": rms(printed), "1 Hz": None},
        "block diagram with dead zone, which reproduces the printed simulation": {
            "2 Hz": of_blocks(2.0),
            "1 Hz": of_blocks(1.0),
        },
    }


def next_experiment(
    machine: DriveMachine, ranking: Sequence[Ranked], spread: Scatter
) -> dict[str, Any]:
    """The test and rate at which the best two hypotheses differ most, in standard deviations."""
    first, second = ranking[0].fit, ranking[1].fit
    found: list[tuple[float, float, str, str, str]] = []
    for rate in OTHER_RATES:
        loops = BenchmarkLoops(rate)
        plants = [f.hypothesis.plant(machine, f.by_key()) for f in (first, second)]
        a, b = loops.metrics(plants)
        difference = np.abs(a - b) / (spread.relative * spread.scale(0.5 * (a + b)))
        i, j = np.unravel_index(int(np.argmax(difference)), difference.shape)
        found.append((float(difference[i, j]), rate, *TESTS[i], METRICS[j]))
    size, rate, controller, motion, metric = max(found)
    return {
        "run": {"controller": controller, "motion": motion, "rate_Hz": rate, "metric": metric},
        "separates": [list(first.hypothesis.ids), list(second.hypothesis.ids)],
        "prediction_difference": size,
        "unit": "standard deviations of the scatter between tests",
        "note": "Run it three times, to measure the scatter instead of inferring it, and keep the time "
        "series: RMS values do not hold the phase that separates inertia from friction.",
    }


def warnings(
    best: Fit,
    tables: dict[float, Experiment],
    spread: Scatter,
    found: Sequence[Observation],
) -> list[str]:
    """What a reader should know of the source and of the best fit."""
    torque, error = (100.0 * abs(d) for d in replicate_differences(tables[2.0]))
    told = [
        f"The scatter between tests, {100 * spread.relative:.1f} %, rests on one replicate: PD and TS in "
        f"translation are the same law and differ by {torque:.0f} % in torque and {error:.0f} % in error. "
        "Two ratios fix a standard deviation to a factor of 2 or so.",
        "The sign and phase of torques and errors are not printed: a load bias, or which side an effect "
        "acts on, shows in RMS values in second order only.",
        "Torque ripple, sensor scale and drift were not tried: RMS values of whole cycles say little of "
        "them.",
    ]
    stuck = [
        f"{effect or 'own'}: {name}" for (effect, name), at in zip(best.keys, best.at_bound) if at
    ]
    if stuck:
        told.append(
            f"The best hypothesis at 2 Hz has parameters at a bound ({', '.join(stuck)}): it bends a "
            "form to a gap it does not describe."
        )
    zero = [o for o in found if o.kind == "cross axis" and o.significant]
    for o in zero:
        told.append(
            f"{o.controller.upper()} at {o.rate_Hz:g} Hz: {o.quantity} is {o.value:g} {o.unit}, "
            f"{o.deviation:.1f} x what the other controllers show; in theory it is zero."
        )
    return told
