"""Which effects: the ranking with its evidence, why the others lost, and the fitted parameters."""

import math
from typing import Any

from ..hypothesis import Fit, price
from ..machine import Machine, Parameter
from ..ranking import Ranked
from ..result import Diagnosis
from .base import Material, Section
from .words import digits_of, interval, listed, number, percent, signature

SHOWN = 8  # hypotheses before the fold
CLOSE = 0.02  # relative difference of held-out errors called the same
CHANCE = 0.05  # probability from which a loser is said to win sometimes


def context(material: Material) -> dict[str, Any]:
    """Rows of the ranking and tables of parameters."""
    d = material.diagnosis
    plain = next(r for r in d.ranking if not r.fit.hypothesis.forms)
    winner = d.verdict.accepted or (plain if d.verdict.verdict == "no_gap" else d.ranking[0])
    rows = [_row(r, i, winner, d) for i, r in enumerate(d.ranking, start=1)]
    rivals = [r for r in d.ranking if r is not winner]
    return {
        "unit": d.machine.residual_unit,
        "believed": d.verdict.accepted is not None or d.verdict.verdict == "no_gap",
        "winner": winner.fit.hypothesis.label,
        "runner_up": rivals[0].fit.hypothesis.label if rivals else "",
        "why": why_not(rivals[0], winner) if rivals else "",
        "signatures": [(i, signature(i, d.machine)) for i in winner.fit.hypothesis.ids],
        "not_separated": [r.fit.hypothesis.label for r in d.verdict.rivals]
        if d.verdict.verdict == "ambiguous"
        else [],
        "shown": rows[:SHOWN],
        "folded": rows[SHOWN:],
        "parameters": [_parameters(r, d) for r in _fitted(d, winner)],
        "findings": [
            (f.effect, f.form, f.evidence, _values(f.parameters)) for f in d.findings
        ],
        "own": _own(d),
        "structures": [
            {"name": s.name, "error": percent(s.relative_error, 1), "share": 100.0 * s.relative_error}
            for s in d.inverse_model
        ],
    }  # fmt: skip


def why_not(rival: Ranked, winner: Ranked) -> str:
    """Why the rival stands behind the winner, in words."""
    mine, its = winner.fit.hypothesis, rival.fit.hypothesis
    ratio = rival.fit.held_out_rms / winner.fit.held_out_rms
    extra = [i for i in its.ids if i not in mine.ids]
    missing = [i for i in mine.ids if i not in its.ids]
    if extra and not missing:
        start = f"it adds {listed(extra)}, and"
    elif missing and not extra:
        start = f"it lacks {listed(missing)}, and"
    else:
        start = "its"
    error = "held-out error" if start == "its" else "the held-out error"
    if ratio > 1.0 + CLOSE:
        words = f"{start} {error} is {number(ratio)} times as large"
    elif ratio > 1.0:
        words = f"{start} {error} is no smaller"
    elif rival.fit.score < winner.fit.score and extra and not missing:
        words = (
            f"{start} the held-out error is only {percent(1.0 - ratio, 1)} smaller; the simpler hypothesis "
            "is likely as well, and preferred"
        )
    else:
        asked = 1.0 - math.exp(price(mine) - price(its))
        words = f"{start} {error} is only {percent(1.0 - ratio, 1)} smaller"
        if asked > 1.0 - ratio:
            words += f"; its freedom must bring {percent(asked, 1)}"
    if rival.probability > CHANCE:
        words += f"; even so it wins in {percent(rival.probability)} of the resamplings"
    return words


def _row(ranked: Ranked, place: int, winner: Ranked, d: Diagnosis) -> dict[str, Any]:
    hypothesis = ranked.fit.hypothesis
    return {
        "place": place,
        "label": hypothesis.label,
        "won": ranked is winner,
        "probability": percent(ranked.probability, 1),
        "share": 100.0 * ranked.probability,
        "held_out": number(ranked.fit.held_out_rms),
        "validation": number(d.validation[frozenset(hypothesis.ids)]),
        "gain": number(math.exp(ranked.gain)),
        "gain_interval": " to ".join(number(math.exp(end)) for end in ranked.gain_interval),
        "parameters": hypothesis.size,
        "why": _remark(ranked, winner, d),
    }


def _remark(ranked: Ranked, winner: Ranked, d: Diagnosis) -> str:
    ambiguous = d.verdict.verdict == "ambiguous"
    if ranked is winner:
        if d.verdict.verdict == "unexplained":
            return "best of those tried, not believed"
        return "leading, not alone" if ambiguous else "accepted"
    reason = why_not(ranked, winner)
    rival = ambiguous and any(ranked is r for r in d.verdict.rivals)
    return f"not separated: {reason}" if rival else reason


def _fitted(d: Diagnosis, winner: Ranked) -> list[Ranked]:
    """Hypotheses whose parameters are worth showing."""
    shown = (winner, *(r for r in d.verdict.rivals if r is not winner))
    return [r for r in shown if r.fit.hypothesis.forms]


def _parameters(ranked: Ranked, d: Diagnosis) -> dict[str, Any]:
    return {
        "label": ranked.fit.hypothesis.label,
        "rows": [row for key, row in _values_of(ranked.fit, d.machine) if key[0]],
    }


def _values_of(fit: Fit, machine: Machine) -> list[tuple[tuple[str, str], dict[str, Any]]]:
    free = {(effect, p.name): p for effect, p in fit.hypothesis.free(machine)}
    rows = []
    for key, unit, value, sd in zip(fit.keys, fit.units, fit.values, fit.deviation):
        half = 1.96 * float(sd)
        row = {
            "effect": key[0],
            "name": key[1],
            "value": number(float(value), unit, digits_of(float(value), half)),
            "interval": interval((value - half, value + half), unit),
            "at_bound": _at_bound(float(value), free[key]),
            "note": _note(float(value), half, free[key]),
        }
        rows.append((key, row))
    return rows


def _note(value: float, half: float, p: Parameter) -> str:
    """What to know about a fitted value: at a bound, or less certain than its whole range to a side."""
    if _at_bound(value, p):
        return "at the end of its range"
    if value - half < p.lower or value + half > p.upper:
        return "interval passes the end of its range"
    return ""


def _at_bound(value: float, p: Parameter) -> bool:
    """Whether a value lies within a thousandth of its range, or its typical size, of a bound."""
    margin = 1e-3 * min(p.upper - p.lower, p.scale)
    return value - p.lower < margin or p.upper - value < margin


def _values(parameters: dict[str, dict[str, Any]]) -> str:
    return ", ".join(
        f"{name} {number(float(p['value']), str(p.get('unit', '')))}"
        for name, p in parameters.items()
    )


def _own(d: Diagnosis) -> list[dict[str, Any]]:
    """The machine's own parameters: nominal, retuned alone and beside the accepted effects."""
    chosen = dict(_values_of(d.chosen, d.machine))
    retuned = dict(_values_of(d.retuned, d.machine))
    rows = []
    for p in d.machine.own:
        alone, beside = retuned.get(("", p.name)), chosen.get(("", p.name))
        rows.append(
            {
                "name": p.name,
                "nominal": number(p.starts[0], p.unit),
                "tolerance": interval((p.lower, p.upper), p.unit),
                "retuned": _marked(alone),
                "chosen": _marked(beside) if beside else "held: an effect takes its place",
            }
        )
    return rows


def _marked(row: dict[str, Any] | None) -> str:
    if row is None:
        return "–"
    return f"{row['value']} (at its bound)" if row["at_bound"] else str(row["value"])


SECTION = Section(key="which", title="Which effect causes it", context=context)
