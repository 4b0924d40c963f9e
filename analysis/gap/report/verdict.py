"""The verdict and how sure it is, in words, with the numbers that carry it."""

from collections.abc import Sequence
from typing import Any

from ..ranking import RESAMPLES, Ranked
from ..result import SIGNAL_PROBABILITY, Diagnosis
from ..verdict import LEAST_REMOVED
from .base import Material, Section
from .words import confidence, listed, meaning, number, percent, place, places

REMAINDER = 1.5  # times the floor from which on what is left is said in front
EVEN = 0.02  # difference of shares that says nothing about where
NOTES = 2  # on how the log was read that stand in front

TITLES = {
    "explained": "Explained",
    "no_gap": "No gap",
    "unexplained": "Unexplained",
    "ambiguous": "Ambiguous",
}


def context(material: Material) -> dict[str, Any]:
    """Headline, confidence, one sentence each on how far and where, and the numbers in front."""
    d = material.diagnosis
    return {
        "kind": d.verdict.verdict,
        "title": TITLES[d.verdict.verdict],
        "headline": _headline(d),
        "effects": _effects(d),
        "confidence": _confidence(d),
        "how_far": _how_far(d),
        "where": _where(d),
        "reason": d.verdict.reason,
        "figures": _figures(d),
        "notes": d.logset.notes[:NOTES],
        "more_notes": len(d.logset.notes[NOTES:]),
    }


def _named(ranked: Ranked, d: Diagnosis, without: Sequence[str] = ()) -> str:
    names = []
    for form in ranked.fit.hypothesis.forms:
        if form.effect in without:
            continue
        at = places(ranked, form.effect, d.machine)
        names.append(f"{form.effect} at {at}" if at else form.effect)
    return listed(names)


def _headline(d: Diagnosis) -> str:
    found = listed(f"{f.effect} ({f.form})" for f in d.findings)
    accepted = d.verdict.accepted
    if d.verdict.verdict == "no_gap":
        return (
            "The nominal model predicts this machine as well as its measurements can tell: "
            "there is no gap to explain."
        )
    if d.verdict.verdict == "unexplained":
        start = f"Beside {found} in the log itself, there" if found else "There"
        return f"{start} is a gap that no effect of the catalogue explains."
    if accepted is None:
        return f"The gap lies in the log, not in the machine: {found}."
    start = f"Beside {found} in the log itself, the" if found else "The"
    if d.verdict.verdict == "ambiguous":
        return f"{start} gap comes from {_alternatives(accepted, d)}; these data cannot tell which."
    return f"{start} gap comes from {_named(accepted, d)}."


def _alternatives(accepted: Ranked, d: Diagnosis) -> str:
    """What all hypotheses that are not separated share, and what they do not."""
    candidates = (accepted, *d.verdict.rivals)
    apart = [i for i in accepted.fit.hypothesis.ids if i not in _shared(d)]
    if not apart or not _shared(d):
        return listed((_named(r, d) for r in candidates), "or")
    rest = listed((_named(r, d, _shared(d)) for r in candidates), "or")
    return f"{_named(accepted, d, apart)}, together with {rest}"


def _shared(d: Diagnosis) -> list[str]:
    """Effects in every hypothesis that the data do not separate."""
    accepted = d.verdict.accepted
    if accepted is None:
        return []
    rivals = [set(r.fit.hypothesis.ids) for r in d.verdict.rivals]
    return [i for i in accepted.fit.hypothesis.ids if all(i in ids for ids in rivals)]


def _effects(d: Diagnosis) -> list[dict[str, str]]:
    """Every effect of the headline with its meaning and probability."""
    rows = [
        {
            "id": f.effect,
            "meaning": f.form,
            "place": place(f.where, d.machine),
            "probability": f"at least {percent(SIGNAL_PROBABILITY)}",
        }
        for f in d.findings
    ]
    accepted = d.verdict.accepted
    seen: set[str] = set()
    for ranked in () if accepted is None else (accepted, *d.verdict.rivals):
        for effect in ranked.fit.hypothesis.ids:
            if effect not in seen:
                seen.add(effect)
                rows.append(
                    {
                        "id": effect,
                        "meaning": meaning(effect, d.machine),
                        "place": places(ranked, effect, d.machine),
                        "probability": percent(d.probability(effect), 1),
                    }
                )
    return rows


def _confidence(d: Diagnosis) -> str:
    best = d.verdict.accepted or d.ranking[0]
    if d.verdict.verdict == "explained" and d.verdict.accepted is None:
        return "Confidence: very high. The stated controller's own law gives it away."
    if d.verdict.verdict == "explained":
        return _confidence_in(best, d)
    if d.verdict.verdict == "ambiguous":
        shares = [
            f"{r.fit.hypothesis.label} wins in {percent(r.probability, 1)}"
            for r in (best, *d.verdict.rivals)
        ]
        sure = [
            f" Confidence in {i}: {confidence(d.probability(i))} ({percent(d.probability(i), 1)})."
            for i in _shared(d)
        ]
        return (
            f"Confidence in one of them: low. {listed(shares)} of {RESAMPLES} resamplings."
            f"{''.join(sure)}"
        )
    if d.verdict.verdict == "no_gap":
        plain = next(r for r in d.ranking if not r.fit.hypothesis.forms)
        ratio = plain.fit.held_out_rms / d.floor
        return (
            f"The retuned model's error is {number(ratio)} times the noise floor. Effects too small to "
            "rise above that floor cannot be excluded."
        )
    removed = d.verdict.removed
    return (
        f"The best hypothesis tried, {d.ranking[0].fit.hypothesis.label}, removes "
        f"{percent(max(removed, 0.0)) if removed is not None else 'none'} of the retuned "
        f"model's error above the floor; "
        f"{percent(LEAST_REMOVED)} are asked before it is believed."
    )


def _confidence_in(accepted: Ranked, d: Diagnosis) -> str:
    """How often the accepted effects are part of what wins, and how often they are all of it."""
    ids = set(accepted.fit.hypothesis.ids)
    containing = [r for r in d.ranking if ids <= set(r.fit.hypothesis.ids)]
    probability = min(sum(r.probability for r in containing), 1.0)
    what = "this effect is" if len(ids) == 1 else "these effects are"
    text = (
        f"Confidence: {confidence(probability)}. In {percent(probability, 1)} of {RESAMPLES} resamplings "
        f"of the held-out data {what} in the winning hypothesis"
    )
    richest = max(containing, key=lambda r: r.probability)
    if richest is not accepted:
        more = listed(i for i in richest.fit.hypothesis.ids if i not in ids)
        text += (
            f"; most often together with {more}, which is not accepted because the simpler hypothesis "
            "is likely as well"
        )
    elif len(containing) > 1 and accepted.probability < probability - 0.01:
        text += f", in {percent(accepted.probability, 1)} alone"
    return (
        f"{text}. That weighs {'it' if len(ids) == 1 else 'them'} against every other hypothesis tried, not against effects outside the "
        "catalogue."
    )


def _how_far(d: Diagnosis) -> str:
    s, unit = d.shrinkage, d.machine.effort_unit
    start = "On the validation runs the rms unexplained effort "
    if s.percent is None or s.ci95 is None:
        return (
            f"{start}of the nominal model is {number(s.before, unit)}, at the noise floor of "
            f"{number(s.floor, unit)}."
        )
    ends = f"95 % interval {s.ci95[0]:.1f} to {s.ci95[1]:.1f}\N{NO-BREAK SPACE}% on these motions"
    verb = "falls" if s.after < s.before else "goes"
    accepted = d.verdict.accepted
    count = len(d.findings) + (len(accepted.fit.hypothesis.ids) if accepted else 0)
    model = (
        f"with {'this' if count == 1 else 'these'} in the model" if count else "by retuning alone"
    )
    left = s.after / s.floor
    rest = f" What is left is {number(left)} times the floor." if left > REMAINDER else ""
    return (
        f"{start}{verb} from {number(s.before, unit)} to {number(s.after, unit)} {model}; the noise "
        f"floor is {number(s.floor, unit)}. That removes {s.percent:.1f}\N{NO-BREAK SPACE}% of the gap ({ends}).{rest}"
    )


def _where(d: Diagnosis) -> str:
    if d.verdict.verdict == "no_gap":
        return ""
    parts = []
    for key, words in (("joints", "on {}"), ("regimes", "in the regime “{}”"), ("bands", "in {}")):
        rows = d.location.get(key, [])
        if len(rows) > 1:
            top = max(rows, key=lambda row: row["share"])
            as_much = [row["name"] for row in rows if top["share"] - row["share"] < EVEN]
            if len(as_much) == 1:
                parts.append(f"{percent(top['share'])} {words.format(top['name'])}")
            elif len(as_much) == len(rows):
                parts.append(f"evenly {words.format(listed(as_much))}")
            else:
                parts.append(f"{percent(top['share'])} each {words.format(listed(as_much))}")
    return f"Where it lies: {listed(parts)}." if parts else ""


def _figures(d: Diagnosis) -> list[dict[str, str]]:
    s, unit = d.shrinkage, d.machine.effort_unit
    plain = next(r for r in d.ranking if not r.fit.hypothesis.forms)
    gone = {
        "label": "times the noise floor",
        "value": number(plain.fit.held_out_rms / d.floor),
        "note": "error of the retuned model",
    }
    if s.percent is not None and s.ci95 is not None:
        gone = {
            "label": "of the gap removed",
            "value": f"{s.percent:.1f}\N{NO-BREAK SPACE}%",
            "note": f"95 % interval {s.ci95[0]:.1f} to {s.ci95[1]:.1f}\N{NO-BREAK SPACE}%",
        }
    relative = [v / s.relative_to_command for v in (s.before, s.after, s.floor)]
    return [
        gone,
        *(
            {
                "label": label,
                "value": number(value, unit),
                "note": f"{percent(share, 1)} of the command",
            }
            for label, value, share in zip(
                ("unexplained before", "unexplained after", "noise floor"),
                (s.before, s.after, s.floor),
                relative,
            )
        ),
    ]


SECTION = Section(key="verdict", title="Verdict", context=context)
