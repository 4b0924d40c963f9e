"""What a diagnosis found, and how it is written as ``diagnosis.json``."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..files import output_folder, write_whole
from .clock import ReplayCheck
from .confusion import Confusion
from .hypothesis import Fit
from .inverse_model import Structure
from .logset import LogSet
from .machine import Machine, RunData
from .order import Share
from .ranking import Ranked
from .shrinkage import Shrinkage
from .signals import SignalFinding
from .verdict import Verdict

SIGNAL_PROBABILITY = 0.99  # of a signal finding, which passes its own strict test or is not made


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
