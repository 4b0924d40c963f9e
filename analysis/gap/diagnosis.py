"""The instrument from log set to diagnosis.

log set -> align clocks -> noise floor -> retuned nominal -> localise -> attribute -> verdict ->
shrinkage on held-out runs. The result is data; ``report`` and the command line only show it.
"""

import json
import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from ..files import output_folder, write_whole
from .attribution import attribute
from .clock import ReplayCheck
from .closed_loop import closed_loop
from .confusion import Confusion, confusion
from .fitting import fit
from .floor import NO_CYCLES
from .hypothesis import Fit, Hypothesis
from .inverse_model import Structure
from .law_error import within_law
from .logset import LogSet, load_logset
from .machine import Array, Machine, RunData, encoder_step, rms
from .machines import read_machine, stated_encoder_step
from .order import Share, order_shares
from .prediction import Predictor
from .ranking import Ranked
from .shrinkage import Shrinkage, shrinkage
from .signals import HOME, SignalFinding, parked
from .verdict import Verdict, confirmed, decide, doubted, in_step, with_findings, with_late_clock

HELD_BACK = 0.3  # share of a lone run's end that is kept for validation
UNSAID = "note", "answer"  # keys of a run that a diagnosis does not repeat
SIGNAL_PROBABILITY = 0.99  # of a signal finding, which passes its own strict test or is not made

Progress = Callable[[str], None]


@dataclass(frozen=True, kw_only=True)
class Leading:
    """The first of the ranking where the verdict accepts none: what it would do on held-out runs."""

    fit: Fit
    shrinkage: Shrinkage
    closed_loop: dict[str, Any] | None


@dataclass(frozen=True, kw_only=True)
class Diagnosis:
    """Everything a diagnosis found."""

    logset: LogSet
    machine: Machine
    runs: tuple[RunData, ...]
    replays: tuple[ReplayCheck, ...]
    findings: tuple[SignalFinding, ...]  # what is wrong with the signals
    floor: float  # on the fit runs [position unit]
    out_of_step: float | None  # what does not repeat over the encoder's noise
    nominal: Fit
    retuned: Fit
    chosen: Fit  # the accepted hypothesis, or the retuned nominal
    ranking: tuple[Ranked, ...]
    validation: dict[frozenset[str], float]  # rms on validation runs [position unit]
    verdict: Verdict
    location: dict[str, list[dict[str, Any]]]
    confusion: Confusion  # which effects these runs cannot separate or show
    shares: tuple[Share, ...]  # of several accepted effects
    shrinkage: Shrinkage
    closed_loop: dict[str, Any]
    leading: Leading | None
    inverse_model: tuple[Structure, ...]  # relative effort errors of growing structures
    warnings: tuple[str, ...]
    next_experiment: dict[str, Any]
    provenance: dict[str, Any]

    def to_json(self) -> dict[str, Any]:
        """``diagnosis.json`` as in FORMAT.md, with a few keys beyond it."""
        accepted = self.verdict.accepted
        return {
            "verdict": self.verdict.verdict,
            "reason": self.verdict.reason,
            "effects": [_finding(f) for f in self.findings]
            + ([] if accepted is None else self._effects(accepted)),
            "ranking": [self._ranked(r) for r in self.ranking],
            "location": self.location,
            "confusion": self.confusion.to_json(),
            "shares": [share.to_json() for share in self.shares],
            "shrinkage": _shrinkage_json(self.shrinkage, self.closed_loop),
            "leading": None if self.leading is None else _leading(self.leading),
            "out_of_step": self.out_of_step,
            "warnings": list(self.warnings),
            "next_experiment": self.next_experiment,
            "inverse_model": [
                {"structure": s.name, "relative_error": s.relative_error, **s.parameters}
                for s in self.inverse_model
            ],
            "retuned": {key[1]: value for key, value in self.retuned.by_key().items()},
            "controller_replay": [
                {"run": c.run, "relative_disagreement": c.disagreement} for c in self.replays
            ],
            "provenance": self.provenance,
        }

    def save(self, folder: str | Path) -> Path:
        """Write ``diagnosis.json`` into the folder, whole or not at all."""
        path = output_folder(Path(folder)) / "diagnosis.json"
        write_whole(path, json.dumps(self.to_json(), indent=1, allow_nan=False))
        return path

    def _effects(self, accepted: Ranked) -> list[dict[str, Any]]:
        candidates = [accepted] if not self.verdict.rivals else [accepted, *self.verdict.rivals]
        effects: dict[str, dict[str, Any]] = {}
        for ranked in candidates:
            for form in ranked.fit.hypothesis.forms:
                kept = [p.name for p in ranked.fit.hypothesis.kept(form)]
                effects.setdefault(
                    form.effect,
                    {
                        "id": form.effect,
                        "form": form.name,
                        "where": form.where(kept),
                        "probability": self.probability(form.effect),
                        "parameters": _parameters(ranked.fit, form.effect),
                    },
                )
        return list(effects.values())

    def probability(self, effect: str) -> float:
        """Probability that the effect acts: of all hypotheses that contain it."""
        with_it = [r.probability for r in self.ranking if effect in r.fit.hypothesis.ids]
        return min(float(sum(with_it)), 1.0)

    def _ranked(self, ranked: Ranked) -> dict[str, Any]:
        hypothesis = ranked.fit.hypothesis
        return {
            "ids": list(hypothesis.ids),
            "forms": [form.name for form in hypothesis.forms],
            "probability": ranked.probability,
            "validation_error": self.validation[frozenset(hypothesis.ids)],
            "held_out_error": ranked.fit.held_out_rms,
            "fit_error": ranked.fit.rms,
            # Not searched: held-out error and gain are its parent's, less what a linear step gains on the fit runs.
            "searched": ranked.fit.searched,
            "gain_over_retuned": ranked.gain,
            "gain_ci95": list(ranked.gain_interval),
            "parameters": hypothesis.size,
            "estimates": {e: _parameters(ranked.fit, e) for e in hypothesis.ids},
            "signature_agreement": ranked.fit.agreement(self.retuned),
        }


def diagnose(
    logset: str | Path | LogSet, *, seed: int = 0, progress: Progress | None = None
) -> Diagnosis:
    """Diagnose a log set.

    Raises InputError for unusable input. ``progress`` is called with a few words before each step.
    """
    with threadpool_limits(1):  # fits run their own threads
        return _diagnose(logset, seed, progress or (lambda text: None))


def _diagnose(logset: str | Path | LogSet, seed: int, tell: Progress) -> Diagnosis:
    started = time.perf_counter()
    log = logset if isinstance(logset, LogSet) else load_logset(logset)
    tell("checking signals and clocks")
    machine, logged = read_machine(log)
    logged = _of_one_encoder([_settled(machine, run) for run in _with_validation(logged)])
    runs, findings = machine.examine(logged, stated_encoder_step(log))
    replays = machine.replays(runs)
    fit_runs = [run for run in runs if run.use == "fit"]
    held_back = [run for run in runs if run.use == "validate"]
    predictor = Predictor(machine, fit_runs)
    tell("retuning the nominal model")
    nominal = _nominal_fit(predictor)
    retuned = fit(predictor, Hypothesis())
    residuals = predictor.residuals(retuned.hypothesis, [retuned.values], retuned.keys)[0]
    floor = _floor(fit_runs, residuals, machine)
    forms = machine.forms(fit_runs)
    ranking = attribute(predictor, retuned, forms, floor, seed, tell)
    retuned_rank = next(r for r in ranking if not r.fit.hypothesis.forms)
    best = predictor.residuals(
        ranking[0].fit.hypothesis, [ranking[0].fit.values], ranking[0].fit.keys
    )[0]
    floor = _floor(fit_runs, best, machine)
    aside = machine.out_of_step(fit_runs, best)
    verdict = decide(ranking, retuned_rank, floor)
    verdict = within_law(verdict, ranking, retuned_rank, floor, machine.law_error)
    if verdict.accepted is not None and parked(fit_runs, verdict.accepted.fit):
        findings = [f for f in findings if f.form != HOME]
    verdict = with_late_clock(in_step(verdict, aside), ranking, findings)
    verdict = with_findings(verdict, findings)
    chosen = verdict.accepted.fit if verdict.accepted else retuned
    tell("verifying on held-out runs")
    as_logged = [run for run in logged if run.use == "validate"]
    shrunk = shrinkage(machine, as_logged, held_back, retuned, chosen, seed)
    errors = _validation_errors(machine, held_back, ranking)
    verdict, ranking = doubted(verdict, ranking, errors)
    verdict = confirmed(verdict, shrunk)
    if verdict.accepted is None and chosen is not retuned:
        chosen = retuned
        shrunk = shrinkage(machine, as_logged, held_back, retuned, chosen, seed)
    loops = closed_loop(
        machine, held_back, {"before": nominal, "retuned": retuned, "after": chosen}
    )
    tell("what these runs cannot tell")
    confused = confusion(predictor, retuned, forms, floor)
    several = verdict.accepted is not None and len(chosen.hypothesis.forms) > 1
    shares = order_shares(predictor, retuned, chosen, [r.fit for r in ranking]) if several else []
    leading = None
    first = ranking[0].fit
    if verdict.verdict == "unexplained" and first.hypothesis.forms:
        leading = Leading(
            fit=first,
            shrinkage=shrinkage(machine, as_logged, held_back, retuned, first, seed),
            closed_loop=closed_loop(machine, held_back, {"leading": first}).get("leading"),
        )
    return Diagnosis(
        logset=log,
        machine=machine,
        runs=tuple(runs),
        replays=tuple(replays),
        findings=tuple(findings),
        floor=floor,
        out_of_step=aside,
        nominal=nominal,
        retuned=retuned,
        chosen=chosen,
        ranking=tuple(ranking),
        validation=errors,
        verdict=verdict,
        location=machine.locate(fit_runs, residuals, seed),
        confusion=confused,
        shares=tuple(shares),
        shrinkage=shrunk,
        closed_loop=loops,
        leading=leading,
        inverse_model=tuple(machine.inverse_model(fit_runs)),
        warnings=(*_warnings(log, runs, replays, confused, shrunk), *machine.remarks(fit_runs)),
        next_experiment=_next_experiment(predictor, ranking, verdict),
        provenance=_provenance(log, seed, predictor.simulations, time.perf_counter() - started),
    )


def _with_validation(runs: Sequence[RunData]) -> list[RunData]:
    """The runs; where none is marked for validation, the end of each fit run is held back."""
    if any(run.use == "validate" for run in runs):
        return list(runs)
    split = []
    for run in runs:
        cut = int(len(run.t) * (1.0 - HELD_BACK))
        step = encoder_step(run.position[:cut]) if run.lsb > 0.0 else run.lsb
        split.append(replace(run, window=slice(0, cut), lsb=step))
        split.append(replace(run, use="validate", window=slice(cut, None), lsb=step))
    return split


def _settled(machine: Machine, run: RunData) -> RunData:
    """The run without the samples that only show what is not known of its first state."""
    first = max(run.window.start or 0, machine.settling(run))
    return replace(run, window=slice(first, run.window.stop))


def _of_one_encoder(runs: Sequence[RunData]) -> list[RunData]:
    """The runs, with the encoder's step that the fit runs show where a run shows none."""
    steps = [run.lsb for run in runs if run.use == "fit" and run.lsb > 0.0]
    step = float(np.median(steps)) if steps else 0.0
    return [run if run.lsb > 0.0 else replace(run, lsb=step) for run in runs]


def _nominal_fit(predictor: Predictor) -> Fit:
    """The nominal model as it stands, as a fit without free parameters."""
    empty = fit(Predictor(_frozen(predictor.machine), predictor.runs), Hypothesis())
    values = predictor.machine.nominal()
    return replace(
        empty,
        keys=tuple(("", name) for name in values),
        values=np.array(list(values.values())),
        deviation=np.zeros(len(values)),
    )


def _frozen(machine: Machine) -> Machine:
    own = tuple(replace(p, lower=p.starts[0], upper=p.starts[0]) for p in machine.own)
    return replace(machine, own=own)


def _floor(runs: Sequence[RunData], residuals: Sequence[Array], machine: Machine) -> float:
    floors, _ = machine.floor(runs, residuals)
    return rms(floors)


def _validation_errors(
    machine: Machine, runs: Sequence[RunData], ranking: Sequence[Ranked]
) -> dict[frozenset[str], float]:
    predictor = Predictor(machine, runs)
    errors = {}
    for ranked in ranking:
        fitted = ranked.fit
        residuals = predictor.residuals(fitted.hypothesis, [fitted.values], fitted.keys)[0]
        flat = np.concatenate([r.ravel() for r in residuals])
        errors[frozenset(fitted.hypothesis.ids)] = float(np.sqrt(np.mean(flat**2)))
    return errors


def _warnings(
    log: LogSet,
    runs: Sequence[RunData],
    replays: Sequence[ReplayCheck],
    confused: Confusion,
    shrunk: Shrinkage,
) -> list[str]:
    warnings = [
        f"{check.run}: the stated controller does not reproduce the logged command (difference "
        f"{100 * check.disagreement:.0f} % rms); closed-loop results for this run are not to be "
        "trusted."
        for check in replays
        if not check.faithful
    ]
    warnings.extend(log.notes)
    if not log.validate:
        warnings.append(_held_back(runs))
    if NO_CYCLES in shrunk.floor_source:
        warnings.append(
            f"The floor is a lower bound ({shrunk.floor_source}): the "
            "machine's own repeatability is unknown."
        )
    warnings += [
        f"{effect} is not visible in this data: {size:.2f} x the noise floor at its typical size, "
        "beyond what the machine's own tolerance hides."
        for effect, size in zip(confused.effects, confused.size)
        if effect in confused.invisible
    ]
    return warnings


def _held_back(runs: Sequence[RunData]) -> str:
    """What was kept for validation although the log set marks nothing."""
    fitted = {run.name for run in runs if run.use == "fit"}
    whole = [run.name for run in runs if run.use == "validate" and run.name not in fitted]
    what = (
        f"{', '.join(whole)} were"
        if whole
        else f"the last {100 * HELD_BACK:.0f} % of every run were"
    )
    return f"No run is marked validate: {what} held back and used for shrinkage only."


def _next_experiment(
    predictor: Predictor, ranking: Sequence[Ranked], verdict: Verdict
) -> dict[str, Any]:
    """The logged motion on which the best two hypotheses differ most: repeat that one first."""
    if len(ranking) < 2 or verdict.verdict == "no_gap":
        return {}
    first, second = ranking[0].fit, ranking[1].fit
    a = predictor.residuals(first.hypothesis, [first.values], first.keys)[0]
    b = predictor.residuals(second.hypothesis, [second.values], second.keys)[0]
    difference = [float(np.sqrt(np.mean((x - y) ** 2))) for x, y in zip(a, b)]
    run = predictor.runs[int(np.argmax(difference))]
    design = "`gapscope design LOGSET` finds the motion that separates the two best"
    return {
        "repeat": {"run": run.name, **{k: v for k, v in run.settings.items() if k not in UNSAID}},
        "separates": [list(first.hypothesis.ids), list(second.hypothesis.ids)],
        "prediction_difference": max(difference),
        "unit": predictor.machine.residual_unit,
        **({"design": design} if predictor.machine.designable else {}),
    }


def _finding(finding: SignalFinding) -> dict[str, Any]:
    return {
        "id": finding.effect,
        "form": finding.form,
        "where": finding.where,
        "probability": SIGNAL_PROBABILITY,
        "parameters": finding.parameters,
        "evidence": finding.evidence,
    }


def _parameters(fitted: Fit, effect: str) -> dict[str, Any]:
    return {
        name: {
            "value": float(value),
            "ci95": [float(value - 1.96 * sd), float(value + 1.96 * sd)]
            if np.isfinite(sd)
            else None,
            "unit": unit,
        }
        for (owner, name), unit, value, sd in zip(
            fitted.keys, fitted.units, fitted.values, fitted.deviation
        )
        if owner == effect
    }


def _leading(leading: Leading) -> dict[str, Any]:
    hypothesis = leading.fit.hypothesis
    return {
        "ids": list(hypothesis.ids),
        "forms": [form.name for form in hypothesis.forms],
        "where": {
            form.effect: form.where([p.name for p in hypothesis.kept(form)])
            for form in hypothesis.forms
        },
        "parameters": {effect: _parameters(leading.fit, effect) for effect in hypothesis.ids},
        "after": leading.shrinkage.after,
        "percent": leading.shrinkage.percent,
        "ci95": list(leading.shrinkage.ci95) if leading.shrinkage.ci95 else None,
        "closed_loop": leading.closed_loop,
    }


def _shrinkage_json(s: Shrinkage, loops: dict[str, Any]) -> dict[str, Any]:
    return {
        "metric": s.metric,
        "before": s.before,
        "retuned": s.retuned,
        "after": s.after,
        "floor": s.floor,
        "percent": s.percent,
        "ci95": list(s.ci95) if s.ci95 else None,
        "intervals_ci95": {
            name: None if ends is None else list(ends) for name, ends in s.intervals.items()
        },
        "rms_command": s.relative_to_command,
        "floor_source": s.floor_source,
        "runs": list(s.runs),
        "closed_loop": loops,
    }


def _provenance(log: LogSet, seed: int, simulations: int, seconds: float) -> dict[str, Any]:
    return {
        "gapscope": version("gapscope"),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "logset": log.name,
        "sha256": log.sha256(),
        "seed": seed,
        "simulations": simulations,
        "seconds": seconds,
    }
