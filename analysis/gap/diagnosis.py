"""The instrument from log set to diagnosis.

log set -> align clocks -> noise floor -> retuned nominal -> localise -> attribute -> verdict ->
shrinkage on held-out runs. The result is data; ``report`` and the command line only show it.
"""

import platform
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from threadpoolctl import threadpool_limits

from .attribution import attribute
from .clock import ReplayCheck
from .closed_loop import closed_loop
from .confusion import Confusion, confusion
from .fitting import fit
from .floor import NO_CYCLES
from .hypothesis import Fit, Hypothesis
from .law_error import within_law
from .logset import LogSet, load_logset
from .machine import Array, Machine, RunData, rms
from .machines import read_machine, refuse_still, stated_encoder_step
from .order import order_shares
from .prediction import Predictor
from .preparation import held_back, prepared
from .ranking import Ranked
from .result import Diagnosis as Diagnosis
from .result import Leading
from .shrinkage import Shrinkage, shrinkage
from .signals import HOME, SignalFinding, parked
from .verdict import Verdict, confirmed, decide, doubted, in_step, with_findings, with_late_clock

UNSAID = "note", "answer"  # keys of a run that a diagnosis does not repeat

Progress = Callable[[str], None]


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
    logged = prepared(machine, logged)
    refuse_still(log, machine, logged)
    runs, findings = machine.examine(logged, stated_encoder_step(log))
    replays = machine.replays(runs)
    fit_runs = [run for run in runs if run.use == "fit"]
    predictor = Predictor(machine, fit_runs)
    tell("retuning the nominal model")
    nominal = _nominal_fit(predictor)
    retuned = fit(predictor, Hypothesis())
    residuals = _residuals(predictor, retuned)
    forms = machine.forms(fit_runs)
    ranking = attribute(predictor, retuned, forms, _floor(fit_runs, residuals, machine), seed, tell)
    best = _residuals(predictor, ranking[0].fit)
    floor, aside = _floor(fit_runs, best, machine), machine.out_of_step(fit_runs, best)
    verdict, findings = _judged(machine, fit_runs, ranking, findings, floor, aside)
    tell("verifying on held-out runs")
    held_out = _HeldOut(machine, logged, runs, retuned, seed)
    verdict, ranking, errors, chosen, shrunk = held_out.verified(verdict, ranking)
    tell("what these runs cannot tell")
    confused = confusion(predictor, retuned, forms, floor)
    several = verdict.accepted is not None and len(chosen.hypothesis.forms) > 1
    shares = order_shares(predictor, retuned, chosen, [r.fit for r in ranking]) if several else []
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
        closed_loop=held_out.loops({"before": nominal, "retuned": retuned, "after": chosen}),
        leading=held_out.leading(verdict, ranking),
        inverse_model=tuple(machine.inverse_model(fit_runs)),
        warnings=(*_warnings(log, runs, replays, confused, shrunk), *machine.remarks(fit_runs)),
        next_experiment=_next_experiment(predictor, ranking, verdict),
        provenance=_provenance(log, seed, predictor.simulations, time.perf_counter() - started),
    )


def _residuals(predictor: Predictor, found: Fit) -> list[Array]:
    """What a fit leaves of the predictor's runs."""
    return predictor.residuals(found.hypothesis, [found.values], found.keys)[0]


def _judged(
    machine: Machine,
    runs: Sequence[RunData],
    ranking: Sequence[Ranked],
    findings: Sequence[SignalFinding],
    floor: float,
    aside: float | None,
) -> tuple[Verdict, list[SignalFinding]]:
    """The verdict that the fit runs allow, and the findings that stand beside it."""
    retuned = next(r for r in ranking if not r.fit.hypothesis.forms)
    verdict = decide(ranking, retuned, floor)
    verdict = within_law(verdict, ranking, retuned, floor, machine.law_error)
    standing = list(findings)
    if verdict.accepted is not None and parked(runs, verdict.accepted.fit):
        standing = [f for f in findings if f.form != HOME]
    verdict = with_late_clock(in_step(verdict, aside), ranking, standing)
    return with_findings(verdict, standing), standing


class _HeldOut:
    """The validation runs, as they were logged and corrected, and what they say of fits."""

    def __init__(
        self,
        machine: Machine,
        logged: Sequence[RunData],
        runs: Sequence[RunData],
        retuned: Fit,
        seed: int,
    ) -> None:
        self.machine, self.retuned, self.seed = machine, retuned, seed
        self.as_logged = [run for run in logged if run.use == "validate"]
        self.runs = [run for run in runs if run.use == "validate"]

    def shrinkage(self, found: Fit) -> Shrinkage:
        """How far a fit shrinks the gap."""
        return shrinkage(self.machine, self.as_logged, self.runs, self.retuned, found, self.seed)

    def loops(self, fits: dict[str, Fit]) -> dict[str, Any]:
        """Closed loops of some fits beside the logs."""
        return closed_loop(self.machine, self.runs, fits)

    def verified(
        self, verdict: Verdict, ranking: Sequence[Ranked]
    ) -> tuple[Verdict, list[Ranked], dict[frozenset[str], float], Fit, Shrinkage]:
        """Verdict and ranking after what these runs take back, validation errors, the fit that stands, its shrinkage."""
        chosen = verdict.accepted.fit if verdict.accepted else self.retuned
        shrunk = self.shrinkage(chosen)
        errors = _validation_errors(self.machine, self.runs, ranking)
        verdict, ranking = doubted(verdict, ranking, errors)
        verdict = confirmed(verdict, shrunk)
        if verdict.accepted is None and chosen is not self.retuned:
            chosen, shrunk = self.retuned, self.shrinkage(self.retuned)
        return verdict, list(ranking), errors, chosen, shrunk

    def leading(self, verdict: Verdict, ranking: Sequence[Ranked]) -> Leading | None:
        """The first of the ranking where the verdict accepts none."""
        first = ranking[0].fit
        if verdict.verdict != "unexplained" or not first.hypothesis.forms:
            return None
        loop = self.loops({"leading": first}).get("leading")
        return Leading(fit=first, shrinkage=self.shrinkage(first), closed_loop=loop)


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
        errors[frozenset(fitted.hypothesis.ids)] = rms(_residuals(predictor, fitted))
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
        warnings.append(held_back(runs))
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


def _next_experiment(
    predictor: Predictor, ranking: Sequence[Ranked], verdict: Verdict
) -> dict[str, Any]:
    """The logged motion on which the best two hypotheses differ most: repeat that one first."""
    if len(ranking) < 2 or verdict.verdict == "no_gap":
        return {}
    first, second = ranking[0].fit, ranking[1].fit
    a, b = _residuals(predictor, first), _residuals(predictor, second)
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
