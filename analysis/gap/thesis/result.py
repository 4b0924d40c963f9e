"""What the diagnosis of the thesis's gap found, as data and as ``diagnosis.json``."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from ...files import output_folder, write_whole
from ..hypothesis import Fit
from ..ranking import Ranked
from ..verdict import Verdict
from .carry_over import CarryOver
from .evidence import Observation
from .experiment import METRICS, Scatter
from .identifiability import Identifiability


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
