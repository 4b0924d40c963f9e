"""The diagnosis of the thesis's own gap, from printed tables to verdict.

Fitted and chosen on the 2 Hz experiment (Table 5-4), checked on the 1 Hz experiment (Table 5-9). A
hypothesis that predicts the held-out table worse than the retuned nominal model is refuted, however
well it does at 2 Hz; its probability then goes to ``unknown``.
"""

import json
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ....models import benchmark, c_drive
from ....models.benchmark import Conditions
from ....models.c_drive import CDriveParameters
from ...files import output_folder, write_whole
from ..drive_machine import DriveMachine
from ..hypothesis import Fit, Hypothesis
from ..machine import Array
from ..machines.c_drive import c_drive_machine
from ..ranking import Ranked
from ..verdict import Verdict, decide
from .candidates import CANDIDATES, candidate_forms
from .carry_over import CarryOver, carry_over, parameter_intervals
from .evidence import Observation, observations
from .experiment import (
    METRICS,
    TESTS,
    Experiment,
    Scatter,
    read_experiment,
    replicate_differences,
    scatter,
)
from .fitting import TableFitter
from .identifiability import Identifiability, identifiability
from .loops import BenchmarkLoops
from .selection import select

SOURCE = "Friedlaender 2015, Tables 5-4 (2 Hz, fitted) and 5-9 (1 Hz, held out)"
TOLERANCE = 0.03  # of the nominal parameters
MOST_LOSS = 0.1  # rise of the log held-out error from which on a hypothesis is refuted
OTHER_RATES = (0.5, 1.25, 2.5)  # [Hz], where a next experiment could be

Progress = Callable[[str], None]


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One printed number beside the models."""

    controller: str
    motion: str
    metric: str
    rate_Hz: float
    measured: float
    deviation: float  # standard deviation, see Scatter
    thesis_simulation: float | None
    nominal: float
    retuned: float
    best: float  # of the best hypothesis at 2 Hz, whether accepted or refuted


@dataclass(frozen=True, kw_only=True)
class ThesisDiagnosis:
    """Everything that was found."""

    verdict: Verdict
    ranking: tuple[Ranked, ...]
    held_out_errors: tuple[float, ...]  # of the ranking on the 1 Hz table, relative
    refuted: tuple[bool, ...]
    scatter: Scatter
    replicate: dict[str, list[float]]
    best: Fit  # the best hypothesis at 2 Hz
    best_carry_over: CarryOver
    intervals: dict[tuple[str, str], tuple[float, float]]  # of the best's parameters
    shrinkage: CarryOver
    entries: tuple[Entry, ...]
    location: dict[str, list[dict[str, Any]]]
    observations: tuple[Observation, ...]
    identifiability: Identifiability
    variants: dict[str, dict[str, float | None]]
    next_experiment: dict[str, Any]
    warnings: tuple[str, ...]
    provenance: dict[str, Any]

    @property
    def unknown_probability(self) -> float:
        """Probability, by resampled tests, of the hypotheses that the held-out table refutes."""
        return float(sum(r.probability for r, gone in zip(self.ranking, self.refuted) if gone))

    def to_json(self) -> dict[str, Any]:
        """``diagnosis.json`` as in FORMAT.md, with keys beyond it."""
        accepted = self.verdict.accepted
        return {
            "verdict": self.verdict.verdict,
            "reason": self.verdict.reason,
            "effects": [] if accepted is None else _effects(accepted, self.intervals),
            "ranking": self._ranking(),
            "location": self.location,
            "shrinkage": _shrinkage(self.shrinkage),
            "warnings": list(self.warnings),
            "next_experiment": self.next_experiment,
            "best_hypothesis": {
                "ids": list(self.best.hypothesis.ids),
                "parameters": _parameters(self.best, self.intervals),
                "fit_error": self.best.rms,
                "held_out": _shrinkage(self.best_carry_over),
            },
            "entries": [asdict(entry) for entry in self.entries],
            "observations": [
                {**asdict(o), "significant": bool(o.significant)} for o in self.observations
            ],
            "identifiability": asdict(self.identifiability),
            "nominal_variants": self.variants,
            "scatter": {
                "relative": self.scatter.relative,
                "additive": dict(zip(METRICS, self.scatter.additive.tolist())),
                "replicate_log_ratios_pd_ts": self.replicate,
            },
            "provenance": self.provenance,
        }

    def _ranking(self) -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = [
            {
                "ids": list(r.fit.hypothesis.ids),
                "forms": [form.name for form in r.fit.hypothesis.forms],
                "probability": 0.0 if gone else r.probability,
                "probability_at_2_Hz": r.probability,
                "refuted_at_1_Hz": gone,
                "validation_error": error,
                "held_out_error": r.fit.held_out_rms,
                "fit_error": r.fit.rms,
                "gain_over_retuned": r.gain,
                "gain_ci95": list(r.gain_interval),
                "parameters": r.fit.hypothesis.size,
            }
            for r, error, gone in zip(self.ranking, self.held_out_errors, self.refuted)
        ]
        if any(self.refuted):
            rows.append(
                {
                    "ids": ["unknown"],
                    "forms": [],
                    "probability": self.unknown_probability,
                    "validation_error": None,
                }
            )
        return sorted(rows, key=lambda row: -row["probability"])

    def save(self, folder: str | Path) -> list[Path]:
        """Write ``diagnosis.json`` and ``report.html`` into the folder, each whole or not at all."""
        from .page import page

        target = output_folder(Path(folder))
        document = json.dumps(self.to_json(), indent=1, allow_nan=False)
        write_whole(target / "diagnosis.json", document + "\n")
        write_whole(target / "report.html", page(self))
        return [target / "diagnosis.json", target / "report.html"]


def diagnose_thesis(
    *,
    seed: int = 0,
    progress: Progress | None = None,
    candidates: Sequence[str] = CANDIDATES,
) -> ThesisDiagnosis:
    """Diagnose the printed experiment; half a minute with all candidates.

    ``progress`` is told a few words at each step; ``candidates`` are the effect ids to try.
    """
    started = time.perf_counter()
    tell = progress or (lambda text: None)
    machine = c_drive_machine(CDriveParameters(), TOLERANCE)
    tables = {rate: read_experiment(rate) for rate in (2.0, 1.0)}
    spread = scatter(tables[2.0])
    fitter, held_out = (
        TableFitter(machine, BenchmarkLoops(rate), tables[rate], spread) for rate in (2.0, 1.0)
    )
    tell("retuning the nominal model")
    nominal, retuned = nominal_fit(fitter), fitter.fit(Hypothesis())
    forms = candidate_forms(machine, tables[2.0], candidates)
    ranking = select(fitter, retuned, forms, seed, tell)
    tell("checking on the 1 Hz table")
    errors = [float(np.sqrt(np.mean(held_out.errors(r.fit) ** 2))) for r in ranking]
    limit = errors[_of_retuned(ranking)] * float(np.exp(MOST_LOSS))
    refuted = [bool(r.fit.hypothesis.forms) and e > limit for r, e in zip(ranking, errors)]
    verdict = _checked(ranking, errors, refuted, spread.relative)
    chosen = verdict.accepted.fit if verdict.accepted else retuned
    best = ranking[0].fit
    shrinkage = carry_over(fitter, held_out, nominal, retuned, chosen, seed)
    found = [o for table in tables.values() for o in observations(table, spread)]
    tell("asking what the table can tell apart")
    seen = identifiability(fitter, retuned, forms, spread.relative)
    return ThesisDiagnosis(
        verdict=verdict,
        ranking=tuple(ranking),
        held_out_errors=tuple(errors),
        refuted=tuple(refuted),
        scatter=spread,
        replicate={
            f"{rate:g} Hz": [float(d) for d in replicate_differences(table)]
            for rate, table in tables.items()
        },
        best=best,
        best_carry_over=shrinkage
        if best is chosen
        else carry_over(fitter, held_out, nominal, retuned, best, seed),
        intervals=parameter_intervals(fitter, best, seed),
        shrinkage=shrinkage,
        entries=_entries((fitter, held_out), nominal, retuned, best, spread),
        location=_location(fitter.errors(retuned)),
        observations=tuple(found),
        identifiability=seen,
        variants=_variants(tables, spread, fitter, held_out, nominal),
        next_experiment=_next_experiment(machine, ranking, spread),
        warnings=tuple(_warnings(best, tables, spread, found)),
        provenance={
            "gapscope": version("gapscope"),
            "python": platform.python_version(),
            "numpy": np.__version__,
            "source": SOURCE,
            "seed": seed,
            "simulated_tests": fitter.loops.simulations + held_out.loops.simulations,
            "seconds": time.perf_counter() - started,
        },
    )


def nominal_fit(fitter: TableFitter) -> Fit:
    """The nominal model as it stands, as a fit without free parameters."""
    own = tuple(replace(p, lower=p.starts[0], upper=p.starts[0]) for p in fitter.machine.own)
    frozen = replace(fitter.machine, own=own)
    empty = TableFitter(frozen, fitter.loops, fitter.experiment, fitter.scatter).fit(Hypothesis())
    return replace(
        empty,
        keys=fitter.problem(Hypothesis()).keys,
        values=np.array([p.starts[0] for p in fitter.machine.own]),
        deviation=np.zeros(len(own)),
    )


def _of_retuned(ranking: Sequence[Ranked]) -> int:
    return next(i for i, r in enumerate(ranking) if not r.fit.hypothesis.forms)


def _checked(
    ranking: Sequence[Ranked], errors: Sequence[float], refuted: Sequence[bool], floor: float
) -> Verdict:
    """Verdict on the fitted table, withdrawn where the held-out table contradicts it."""
    retuned = _of_retuned(ranking)
    verdict = decide(ranking, ranking[retuned], floor)
    best = verdict.accepted or ranking[0]
    place = next(i for i, r in enumerate(ranking) if r is best)
    if not refuted[place]:
        return verdict
    reason = (
        f"{verdict.reason} It also fails the check: fitted at 2 Hz, it predicts the 1 Hz table with a "
        f"relative error of {100 * errors[place]:.0f} %, against {100 * errors[retuned]:.0f} % of the "
        "retuned nominal model."
    )
    return replace(verdict, verdict="unexplained", reason=reason, accepted=None)


def _entries(
    fitters: Sequence[TableFitter], nominal: Fit, retuned: Fit, best: Fit, spread: Scatter
) -> tuple[Entry, ...]:
    entries = []
    for fitter in fitters:
        table = fitter.experiment
        models = [fitter.metrics(f) for f in (nominal, retuned, best)]
        deviation = spread.relative * spread.scale(table.measured)
        for i, (controller, motion) in enumerate(TESTS):
            for j, metric in enumerate(METRICS):
                printed = float(table.simulated[i, j])
                entries.append(
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
    return tuple(entries)


def _location(errors: Array) -> dict[str, list[dict[str, Any]]]:
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


def _variants(
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


def _next_experiment(
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


def _warnings(
    best: Fit,
    tables: dict[float, Experiment],
    spread: Scatter,
    found: Sequence[Observation],
) -> list[str]:
    torque, error = (100.0 * abs(d) for d in replicate_differences(tables[2.0]))
    warnings = [
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
        warnings.append(
            f"The best hypothesis at 2 Hz has parameters at a bound ({', '.join(stuck)}): it bends a "
            "form to a gap it does not describe."
        )
    zero = [o for o in found if o.kind == "cross axis" and o.significant]
    for o in zero:
        warnings.append(
            f"{o.controller.upper()} at {o.rate_Hz:g} Hz: {o.quantity} is {o.value:g} {o.unit}, "
            f"{o.deviation:.1f} x what the other controllers show; in theory it is zero."
        )
    return warnings


def _effects(
    accepted: Ranked, intervals: dict[tuple[str, str], tuple[float, float]]
) -> list[dict[str, Any]]:
    fitted = accepted.fit
    parameters = _parameters(fitted, intervals)
    return [
        {
            "id": form.effect,
            "form": form.name,
            "where": form.where([p.name for p in fitted.hypothesis.kept(form)]),
            "probability": accepted.probability,
            "parameters": {k.split(": ")[1]: v for k, v in parameters.items() if form.effect in k},
        }
        for form in fitted.hypothesis.forms
    ]


def _parameters(
    fitted: Fit, intervals: dict[tuple[str, str], tuple[float, float]]
) -> dict[str, Any]:
    return {
        f"{key[0] or 'nominal'}: {key[1]}": {
            "value": float(value),
            "ci95": list(intervals[key]) if key in intervals else None,
            "unit": unit,
            "at_bound": bool(at),
        }
        for key, value, unit, at in zip(fitted.keys, fitted.values, fitted.units, fitted.at_bound)
    }


def _shrinkage(c: CarryOver) -> dict[str, Any]:
    return {
        "metric": "rms relative error of the 27 printed values at 1 Hz, held out",
        **asdict(c),
        "ci95": list(c.ci95) if c.ci95 else None,
        "floor_source": "PD and TS in pure translation at 1 Hz, one control law measured twice",
    }
