"""The score of a blind run: what was named, how often rightly, and how well it knew.

A diagnosis names a set of ids: its ``effects`` if ``explained``, none if ``no_gap``, ``unknown`` if
``unexplained``. ``ambiguous`` names nothing; its first hypothesis still counts for top-1 and its
first two for top-2. An answer is right when the sets are equal: of a pair, both and nothing else.

``blind_rates`` makes the numbers of a run from its outcomes. Its targets are judged on *visible* cases, whose every
effect moves the residual by at least five times the repeatability floor (measured by the generator, against the same
machine without it). Proportions carry Wilson intervals, the rest percentile-bootstrap intervals over cases, both 95 %.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

VISIBLE = 5.0  # times the floor
UNKNOWN = frozenset({"unknown"})
EXPLAINED, NO_GAP, UNEXPLAINED, AMBIGUOUS, FAILED = (
    "explained",
    "no_gap",
    "unexplained",
    "ambiguous",
    "failed",
)
# Twins where they last a sample or so: then both are to be named.
LATE = frozenset({"actuator.delay", "actuator.lag"})
# Effects whose true size counts along the torque, and the estimate against it.
OPPOSED = frozenset({"load.bias"})


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """One case: its answer beside what the diagnosis said."""

    name: str
    kind: str  # none, single, double, off_library
    truth: frozenset[str]
    cause: tuple[str, ...]
    visible: bool
    strength: float
    verdict: str
    first: frozenset[str]  # best hypothesis; of an abstention, the one it would have named
    named: tuple[frozenset[str], ...]  # the two best, best first
    confidence: float | None  # probability of ``first``
    shrinkage: float | None  # claimed, %
    attainable: float | None  # with the machine's own model, %
    parameters: tuple[tuple[str, str, float, float], ...]  # id, name, true, estimated
    seconds: float
    error: str | None

    @property
    def right(self) -> bool:
        """The first hypothesis is the answer, exactly."""
        return self.first == self.truth

    @property
    def right_in_two(self) -> bool:
        """One of the first two hypotheses is the answer."""
        return self.truth in (self.first, *self.named)

    @property
    def names_both_late(self) -> bool:
        """The two named are the answer and the same with a delay for its lag, or a lag for its delay."""
        both = len(self.named) == 2 and self.named[0] ^ self.named[1] == LATE
        return self.verdict == AMBIGUOUS and both and self.truth in self.named

    @property
    def claimed(self) -> bool:
        """The diagnosis commits itself to a mechanism."""
        return self.verdict == EXPLAINED and self.first != UNKNOWN


def outcome(answer: dict[str, Any], result: dict[str, Any]) -> Outcome:
    """Read one opened answer and one result."""
    diagnosis = result["diagnosis"] or {}
    verdict, error = str(diagnosis.get("verdict")), result["error"]
    if error is None and verdict not in (EXPLAINED, NO_GAP, UNEXPLAINED, AMBIGUOUS):
        error = f"verdict {verdict!r}; expected explained, no_gap, unexplained or ambiguous"
    verdict = FAILED if error is not None else verdict
    ranking = diagnosis.get("ranking") or []
    ranked = [frozenset(entry["ids"]) for entry in ranking]
    effects = diagnosis.get("effects") or []
    accepted = frozenset(effect["id"] for effect in effects)
    # What is wrong with the signals is found before the ranking and belongs to each of its hypotheses.
    found = frozenset(effect["id"] for effect in effects if "evidence" in effect)
    first = {
        EXPLAINED: accepted,
        NO_GAP: frozenset(),
        UNEXPLAINED: UNKNOWN,
        AMBIGUOUS: ranked[0] | found if ranked else UNKNOWN,
        FAILED: frozenset({FAILED}),
    }[verdict]
    shares = [v for k, v in answer["strength"].items() if k != "all"] or [answer["strength"]["all"]]
    truth = frozenset(answer["answer"])
    return Outcome(
        name=answer["name"],
        kind=answer["kind"],
        truth=truth,
        cause=tuple(answer["cause"]),
        visible=answer["kind"] == "none" or min(shares) >= VISIBLE,
        strength=answer["strength"]["all"],
        verdict=verdict,
        first=first,
        named=tuple([first, *(r | found for r in ranked if r | found != first)][:2]),
        confidence=_confidence(diagnosis, first - found if verdict == AMBIGUOUS else first, ranking)
        if verdict in (EXPLAINED, AMBIGUOUS)
        else None,
        shrinkage=(diagnosis.get("shrinkage") or {}).get("percent"),
        attainable=answer.get("attainable_percent"),
        parameters=tuple(_comparable(answer, diagnosis)) if first == truth else (),
        seconds=result["seconds"],
        error=error,
    )


def _confidence(
    diagnosis: dict[str, Any], first: frozenset[str], ranking: list[dict[str, Any]]
) -> float | None:
    for entry in ranking:
        probability = entry.get("probability")
        if frozenset(entry["ids"]) == first and probability is not None:
            return float(probability)
    effects = diagnosis.get("effects") or []
    stated = [float(e["probability"]) for e in effects if e.get("probability") is not None]
    return float(np.prod(stated)) if stated else None


def _comparable(
    answer: dict[str, Any], diagnosis: dict[str, Any]
) -> list[tuple[str, str, float, float]]:
    """Parameters that must be the same quantity: alone in their effect with their unit, on both sides.

    True values carry the unit in their name (``delay_s``), estimates beside the value.
    """
    pairs = []
    for effect in diagnosis.get("effects") or []:
        true = [
            (name, value)
            for name, value in answer["parameters"].get(effect["id"], {}).items()
            if isinstance(value, int | float) and value != 0
        ]
        estimates = [e for e in (effect.get("parameters") or {}).items() if isinstance(e[1], dict)]
        for unit in {str(value.get("unit")) for _, value in estimates}:
            suffix = "_" + unit.replace(" ", "").replace("/", "_per_")
            mine = [entry for entry in true if entry[0].endswith(suffix)]
            theirs = [value["value"] for _, value in estimates if value.get("unit") == unit]
            if len(mine) == len(theirs) == 1:
                sign = -1.0 if effect["id"] in OPPOSED else 1.0
                pairs.append((effect["id"], mine[0][0], float(mine[0][1]), sign * theirs[0]))
    return pairs


def risk_coverage(outcomes: Sequence[Outcome]) -> list[tuple[float, float]]:
    """(coverage, risk) as ever less confident claims are accepted, over cases that have a gap.

    Coverage is the share of those cases with an accepted claim, risk the share of wrong ones in it.
    """
    gaps = [o for o in outcomes if o.kind != "none"]
    claims = sorted((o for o in gaps if o.claimed), key=lambda o: -(o.confidence or 0.0))
    wrong = np.cumsum([not o.right for o in claims])
    return [
        ((i + 1) / len(gaps), float(wrong[i]) / (i + 1))
        for i in range(len(claims))
        if i + 1 == len(claims) or claims[i].confidence != claims[i + 1].confidence
    ]


def confusion(outcomes: Sequence[Outcome]) -> tuple[list[str], list[str], NDArray[np.int_]]:
    """Truths, predictions and counts of the single-effect, no-effect and off-library cases."""
    told = [o for o in outcomes if o.kind != "double"]
    truths = sorted({_word(o.truth) for o in told}, key=_order)
    predictions = sorted({*truths, *(_prediction(o) for o in told)}, key=_order)
    counts = np.zeros((len(truths), len(predictions)), dtype=int)
    for o in told:
        counts[truths.index(_word(o.truth)), predictions.index(_prediction(o))] += 1
    return truths, predictions, counts


def _word(ids: frozenset[str]) -> str:
    if len(ids) > 1:
        return "several"
    return next(iter(ids), NO_GAP)


def _prediction(o: Outcome) -> str:
    return o.verdict if o.verdict in (AMBIGUOUS, FAILED) else _word(o.first)


def _order(word: str) -> tuple[int, str]:
    last = (NO_GAP, "unknown", "several", AMBIGUOUS, FAILED)
    return (last.index(word) + 1 if word in last else 0, word)
