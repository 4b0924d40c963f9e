"""The two hypotheses an experiment should tell apart."""

from collections.abc import Sequence
from dataclasses import dataclass

from ...errors import InputError
from ..ranking import Ranked
from ..result import Diagnosis


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Two hypotheses of a ranking, neither a part of the other, and why these."""

    first: Ranked
    second: Ranked
    remark: str


def top_two(diagnosis: Diagnosis) -> Pair:
    """The accepted hypothesis and its first rival, or the best two where there is no rival.

    Raises InputError where there is nothing to separate: no gap, or a single hypothesis.
    """
    verdict = diagnosis.verdict
    if verdict.verdict == "no_gap":
        raise InputError(
            diagnosis.logset.folder,
            "the verdict is no_gap: there is nothing to separate",
            "a log set with a gap",
            "Repeat a motion often to lower the noise floor and look for smaller effects.",
        )
    effects = [r for r in diagnosis.ranking if r.fit.hypothesis.forms]
    first = verdict.accepted or (effects[0] if effects else None)
    others = [] if first is None else [*verdict.rivals, *_apart(effects, first)]
    others = [r for r in others if r is not first]
    if first is None or not others:
        raise InputError(
            diagnosis.logset.folder,
            "the ranking holds no two hypotheses of which neither is a part of the other",
            "two hypotheses to separate",
        )
    second = others[0]
    if verdict.verdict == "ambiguous":
        remark = "The data do not separate these two."
    elif verdict.verdict == "explained":
        remark = "The verdict is explained; this motion would only widen the margin to the second."
    else:
        remark = "No hypothesis explains the gap; these two come nearest."
    return Pair(first=first, second=second, remark=remark)


def _apart(ranking: Sequence[Ranked], first: Ranked) -> list[Ranked]:
    mine = set(first.fit.hypothesis.ids)
    return [
        r
        for r in ranking
        if not (mine <= set(r.fit.hypothesis.ids) or set(r.fit.hypothesis.ids) <= mine)
    ]
