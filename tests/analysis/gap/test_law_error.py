"""What is not claimed where the law itself may be off: residuals made up for each rule, floor 1."""

from dataclasses import dataclass
from typing import Any

import pytest

from gapscope.analysis.gap.law_error import LawError, within_law
from gapscope.analysis.gap.verdict import NEAR_FLOOR, Verdict

ERROR = LawError(law=0.4, form=0.4)


@dataclass(frozen=True)
class FakeHypothesis:
    ids: tuple[str, ...]
    size: int

    @property
    def label(self) -> str:
        return " + ".join(self.ids)


@dataclass(frozen=True)
class FakeFit:
    hypothesis: FakeHypothesis
    held_out_rms: float


@dataclass(frozen=True)
class FakeRanked:
    fit: FakeFit


def ranked(ids: str, rms: float, size: int = 2) -> Any:
    return FakeRanked(FakeFit(FakeHypothesis(tuple(ids.split()), size), rms))


RETUNED = ranked("", 10.0, 0)


def judged(*ranking: Any, error: LawError | None = ERROR) -> Verdict:
    """The verdict on an explanation that is the first of a ranking."""
    claim = Verdict(
        verdict="explained", reason="Fits.", accepted=ranking[0], rivals=(), removed=0.9
    )
    return within_law(claim, [*ranking, RETUNED], RETUNED, 1.0, error)


def test_an_exact_law_takes_nothing_back() -> None:
    ranking = (ranked("a b", 2.0 * NEAR_FLOOR), ranked("a", 2.0 * NEAR_FLOOR))
    assert judged(*ranking, error=None).verdict == "explained"


@pytest.mark.parametrize(("share", "verdict"), [(0.99, "explained"), (1.01, "unexplained")])
def test_an_explanation_ends_near_the_floor(share: float, verdict: str) -> None:
    found = judged(ranked("a", share * NEAR_FLOOR), ranked("b", 8.0))
    assert found.verdict == verdict
    assert (found.accepted is None) == (verdict == "unexplained")


# rms^2 that a rival may be worse by: the law's error squared.
@pytest.mark.parametrize(("worse", "verdict"), [(0.15, "ambiguous"), (0.17, "explained")])
def test_a_rival_within_the_error_of_the_law_is_not_told_apart(worse: float, verdict: str) -> None:
    found = judged(ranked("a", 1.0), ranked("b", (1.0 + worse) ** 0.5))
    assert found.verdict == verdict
    assert [r.fit.hypothesis.ids for r in found.rivals] == [("b",)] * (verdict == "ambiguous")


def test_a_rival_with_more_parameters_or_effects_is_none() -> None:
    others = (ranked("b", 1.01, size=3), ranked("b c", 1.01), ranked("a b", 1.0))
    assert judged(ranked("a", 1.0), *others).verdict == "explained"


# Of 10, one effect leaves r; two may leave 1 by its form's misfit while r^2 - 1 < 0.16 (100 - r^2), r < 3.83.
@pytest.mark.parametrize(("rest", "verdict"), [(3.8, "ambiguous"), (3.9, "explained")])
def test_a_further_effect_is_larger_than_the_misfit_of_the_first(rest: float, verdict: str) -> None:
    found = judged(
        ranked("a b", 1.0, size=4), ranked("a", rest), ranked("c", rest), ranked("b", 8.0)
    )
    assert found.verdict == verdict
    both = verdict == "ambiguous"
    assert [r.fit.hypothesis.ids for r in found.rivals] == [("a",), ("c",)] * both
    assert ("a + b and a and c" in found.reason) == both
