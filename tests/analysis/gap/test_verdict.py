"""What takes a claim back: validation runs that contradict it, and twins that share their wins."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from gapscope.analysis.gap.attribution import TWIN, _shared_wins
from gapscope.analysis.gap.shrinkage import Shrinkage
from gapscope.analysis.gap.verdict import GAP_RATIO, Verdict, confirmed

NO_GAP = Verdict(verdict="no_gap", reason="Small.", accepted=None, rivals=(), removed=None)


def held_out(**changes: Any) -> Shrinkage:
    at_floor = Shrinkage(
        metric="rms",
        before=1.0,
        retuned=1.0,
        after=1.0,
        floor=1.0,
        percent=None,
        ci95=None,
        relative_to_command=1.0,
        floor_source="cycle-to-cycle repeatability",
        runs=("v.csv",),
    )
    return replace(at_floor, **changes)


def test_no_gap_stands_where_validation_runs_agree() -> None:
    assert confirmed(NO_GAP, held_out(retuned=0.99 * GAP_RATIO)) is NO_GAP


@pytest.mark.parametrize("verdict", ["no_gap", "explained"])
def test_a_gap_on_validation_runs_only_takes_the_claim_back(verdict: str) -> None:
    taken = confirmed(replace(NO_GAP, verdict=verdict), held_out(retuned=2.0))
    assert taken.verdict == "unexplained"
    assert "2.0 x the floor" in taken.reason


def test_a_floor_without_repeats_contradicts_nothing() -> None:
    source = "encoder resolution; the runs hold no repeated cycles"
    assert confirmed(NO_GAP, held_out(retuned=9.0, floor_source=source)) is NO_GAP


def test_twins_share_what_they_win_and_others_do_not() -> None:
    scores = np.array([[0.0, 0.0], [0.5 * TWIN, 2.0 * TWIN], [1.0, 1.0]])
    assert _shared_wins(scores) == pytest.approx([1.5, 0.5, 0.0])
