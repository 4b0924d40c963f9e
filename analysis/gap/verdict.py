"""The verdict: what may be claimed from a ranking, and when to say nothing."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from .floor import NO_CYCLES
from .ranking import Ranked
from .selection import LEAST_GAIN
from .shrinkage import Shrinkage
from .signals import SignalFinding

NEGLIGIBLE = (
    1.15  # a retuned residual below this multiple of the floor is no gap, whatever improves it
)
GAP_RATIO = 1.25  # nor is one below this multiple that no effect improves
OUT_OF_STEP = 1.25  # what does not repeat may exceed the encoder's noise by this ratio
LEAST_REMOVED = 0.75  # an explanation removes this share of what lies between retuned and floor
LEAST_REMOVED_ROUGH = (
    0.5  # as LEAST_REMOVED, of impacts: the least difference in timing leaves much
)
NEAR_FLOOR = 1.3  # an explanation comes this near the floor on held-out runs, as a ratio,
MOST_LEFT = 0.05  # or leaves no more than this share of what lies between retuned and floor
LEAST_WORSE = 1.1  # ratio of validation errors at which an effect that worsens them is doubted
RIVAL_PROBABILITY = 0.05  # a rival this likely makes the choice ambiguous


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """A verdict with its reason in words and the hypotheses it rests on."""

    verdict: str  # explained, no_gap, unexplained or ambiguous
    reason: str
    accepted: Ranked | None
    rivals: tuple[Ranked, ...]
    removed: float | None  # share of the gap between retuned and floor that the best one removes


def decide(ranking: Sequence[Ranked], retuned: Ranked, floor: float) -> Verdict:
    """Verdict over a ranking, best first; ``floor`` in the unit of the held-out residuals."""
    ratio = retuned.fit.held_out_rms / floor
    best = _smallest_likely(ranking)
    gap = retuned.fit.held_out_rms - floor
    removed = (retuned.fit.held_out_rms - best.fit.held_out_rms) / gap if gap > 0.0 else None
    idle = not best.fit.hypothesis.forms or best.gain_interval[0] < LEAST_GAIN
    if idle or ratio < NEGLIGIBLE:
        if ratio < GAP_RATIO:
            return Verdict(
                verdict="no_gap",
                reason=f"The nominal model, retuned inside its tolerance, predicts to {ratio:.2f} x "
                "the noise floor; what an effect could improve on that is negligible.",
                accepted=None,
                rivals=(),
                removed=None,
            )
        return Verdict(
            verdict="unexplained",
            reason=f"The retuned model is {_times(ratio)} x the noise floor away, but no known effect "
            "removes a significant part of that.",
            accepted=None,
            rivals=(),
            removed=removed,
        )
    label = best.fit.hypothesis.label
    least = LEAST_REMOVED_ROUGH if best.fit.hypothesis.rough else LEAST_REMOVED
    if removed is None or removed < least:
        return Verdict(
            verdict="unexplained",
            reason=f"The best hypothesis, {label}, removes only {100 * (removed or 0):.0f} % of the "
            f"{_above(ratio)}; {100 * least:.0f} % are asked.",
            accepted=None,
            rivals=tuple(ranking[:2]),
            removed=removed,
        )
    rivals = tuple(r for r in ranking if r is not best and _is_rival(r, best))
    if rivals:
        names = " and ".join(r.fit.hypothesis.label for r in (best, *rivals))
        return Verdict(
            verdict="ambiguous",
            reason=f"These data do not separate {names}.",
            accepted=best,
            rivals=rivals,
            removed=removed,
        )
    return Verdict(
        verdict="explained",
        reason=f"{label} removes {100 * removed:.0f} % of the {_above(ratio)}.",
        accepted=best,
        rivals=(),
        removed=removed,
    )


def _above(ratio: float) -> str:
    """What a hypothesis removes a share of, ``ratio`` times the floor: not what ``Shrinkage.percent`` is of."""
    return (
        f"retuned model's prediction error above the floor ({_times(ratio)} x it), on parts of the fit runs "
        "held out in turn"
    )


def _times(ratio: float) -> str:
    """A ratio to the floor: one decimal, or three digits."""
    return f"{ratio:.1f}" if ratio < 99.95 else f"{float(f'{ratio:.3g}'):.0f}"


def _smallest_likely(ranking: Sequence[Ranked]) -> Ranked:
    """The best hypothesis, or a smaller one inside it that is likely as well: parsimony."""
    best = ranking[0]
    smaller = [
        r
        for r in ranking[1:]
        if set(r.fit.hypothesis.ids) < best.fit.hypothesis.contained
        and r.probability > RIVAL_PROBABILITY
    ]
    return min(smaller, key=lambda r: len(r.fit.hypothesis.ids)) if smaller else best


def _is_rival(other: Ranked, best: Ranked) -> bool:
    """Likely, and neither a part nor an extension of the best."""
    mine, its = best.fit.hypothesis, other.fit.hypothesis
    nested = set(mine.ids) <= its.contained or set(its.ids) <= mine.contained
    return other.probability > RIVAL_PROBABILITY and not nested


def with_findings(verdict: Verdict, findings: Sequence[SignalFinding]) -> Verdict:
    """The verdict on the machine joined with what was found wrong with its signals."""
    if not findings:
        return verdict
    signals = "; ".join(f"{f.effect} ({f.form}): {f.evidence}" for f in findings)
    joined = "explained" if verdict.verdict == "no_gap" else verdict.verdict
    rest = "Beyond that, no gap." if verdict.verdict == "no_gap" else verdict.reason
    return replace(verdict, verdict=joined, reason=f"{signals}. {rest}")


def with_late_clock(
    verdict: Verdict, ranking: Sequence[Ranked], findings: Sequence[SignalFinding]
) -> Verdict:
    """The verdict, or ``ambiguous`` where a delay or lag is claimed of a log whose clock was off.

    A clock corrected by a little too little looks like an actuator that is late.
    """
    off = any(f.effect == "sensor.timing" for f in findings)
    if not off or verdict.verdict != "explained" or verdict.accepted is None:
        return verdict
    hypothesis = verdict.accepted.fit.hypothesis
    on_time = {form.effect for form in hypothesis.forms if not form.shifts}
    if len(on_time) == len(hypothesis.forms):
        return verdict
    rivals = [r for r in ranking if set(r.fit.hypothesis.ids) == on_time]
    return replace(
        verdict,
        verdict="ambiguous",
        reason=f"The clock of the log was off, and what is left of that looks like an actuator that is "
        f"late. {verdict.reason}",
        rivals=tuple(rivals),
    )


def in_step(verdict: Verdict, out_of_step: float | None) -> Verdict:
    """The verdict, or ``unexplained`` where a disturbance out of step with the motion has raised the floor.

    ``out_of_step`` is that of ``floor.py``. Impacts of a clearance do not repeat either. White noise in the forces of
    the machine counts as a disturbance: commands that get lost look the same.
    """
    rough = verdict.accepted is not None and verdict.accepted.fit.hypothesis.rough
    if out_of_step is None or out_of_step <= OUT_OF_STEP or rough:
        return verdict
    if verdict.verdict not in ("no_gap", "explained"):
        return verdict
    return replace(
        verdict,
        verdict="unexplained",
        reason=f"What does not repeat is {out_of_step:.1f} x the noise of the measurement: "
        f"a disturbance out of step with the motion (a hum, knocks, lost commands, noise in the "
        f"forces), which no effect of the catalogue makes. "
        f"{verdict.reason}",
        accepted=None,
    )


def doubted(
    verdict: Verdict, ranking: Sequence[Ranked], errors: Mapping[frozenset[str], float]
) -> tuple[Verdict, list[Ranked]]:
    """The verdict, or ``ambiguous`` where the validation runs are predicted better without an effect.

    ``errors`` are validation errors by the ids of a hypothesis. They choose nothing, they take back:
    in the ranking that is returned, the two share the probability of both.
    """
    kept = verdict, list(ranking)
    if verdict.verdict != "explained" or verdict.accepted is None:
        return kept
    ids = frozenset(verdict.accepted.fit.hypothesis.ids)
    smaller = [
        r
        for r in ranking
        if r.fit.hypothesis.ids
        and frozenset(r.fit.hypothesis.ids) < ids
        and errors[ids] > LEAST_WORSE * errors[frozenset(r.fit.hypothesis.ids)]
    ]
    if not smaller:
        return kept
    rival = min(smaller, key=lambda r: errors[frozenset(r.fit.hypothesis.ids)])
    half = 0.5 * (verdict.accepted.probability + rival.probability)
    shared = {id(r): replace(r, probability=half) for r in (verdict.accepted, rival)}
    accepted, rival = shared.values()
    found = replace(
        verdict,
        verdict="ambiguous",
        reason=f"The fit runs ask for {accepted.fit.hypothesis.label}, but the validation "
        f"runs are predicted better by {rival.fit.hypothesis.label} alone.",
        accepted=accepted,
        rivals=(rival,),
    )
    return found, [shared.get(id(r), r) for r in ranking]


def confirmed(verdict: Verdict, held_out: Shrinkage) -> Verdict:
    """The verdict, or ``unexplained`` where the validation runs contradict it.

    Validation runs can only take a claim back, never choose one. A floor that is the encoder's
    resolution for want of repeated motions measures no gap, but what is accepted must remove a share of it there as
    well. The residual of impacts, which the least difference in timing makes large, need only fall.
    """
    if NO_CYCLES in held_out.floor_source:
        return _removes_as_well(verdict, held_out)
    before, after = held_out.retuned / held_out.floor, held_out.after / held_out.floor
    if verdict.accepted is None:
        hidden = verdict.verdict in ("no_gap", "explained") and before > GAP_RATIO
        reason = (
            f"The validation runs hold a gap ({_times(before)} x the floor) that the fit runs do not "
            "show well enough to tell its cause."
        )
    else:
        rough = verdict.accepted.fit.hypothesis.rough
        left = (after - 1.0) / max(before - 1.0, 1e-12)
        far = after > NEAR_FLOOR and left > MOST_LEFT
        if rough:
            far = before > GAP_RATIO and left >= 1.0
        hidden = verdict.verdict == "explained" and far
        reason = (
            f"On the validation runs {verdict.accepted.fit.hypothesis.label} still leaves "
            f"{_times(after)} x the floor ({_times(before)} x before; {NEAR_FLOOR} x at most are asked): "
            "something else acts as well, or instead."
        )
    if not hidden:
        return verdict
    return replace(
        verdict, verdict="unexplained", reason=f"{reason} {verdict.reason}", accepted=None
    )


def _removes_as_well(verdict: Verdict, held_out: Shrinkage) -> Verdict:
    """``confirmed`` for runs without repeated cycles, whose floor is a lower bound."""
    gap = held_out.retuned - held_out.floor
    if verdict.accepted is None or verdict.verdict != "explained" or gap <= 0.0:
        return verdict
    removed = (held_out.retuned - held_out.after) / gap
    rough = verdict.accepted.fit.hypothesis.rough
    if removed > (0.0 if rough else LEAST_REMOVED_ROUGH):
        return verdict
    done = f"removes {100.0 * removed:.0f} %"
    return replace(
        verdict,
        verdict="unexplained",
        reason=f"On the validation runs {verdict.accepted.fit.hypothesis.label} {done} of the retuned "
        f"model's unexplained effort above the floor: something else acts as well, or instead. {verdict.reason}",
        accepted=None,
    )
