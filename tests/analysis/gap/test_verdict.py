"""What takes a claim back: validation runs that contradict it, and twins that share their wins."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from gapscope.analysis.gap.attribution import _holds_nothing
from gapscope.analysis.gap.hypothesis import price
from gapscope.analysis.gap.ranking import (
    LATE_TWIN,
    TWIN,
    Ranked,
    _best_of_twins,
    _fair_price,
    _late_groups,
    _shared_wins,
)
from gapscope.analysis.gap.shrinkage import Shrinkage
from gapscope.analysis.gap.verdict import (
    GAP_RATIO,
    Verdict,
    confirmed,
    decide,
    doubted,
    with_late_clock,
)

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
        intervals={},
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


@pytest.mark.parametrize(
    ("after", "verdict"), [(1.0, "explained"), (7.0, "unexplained"), (20.0, "unexplained")]
)
def test_without_repeats_a_claim_must_still_remove_its_share(after: float, verdict: str) -> None:
    claim = decide([DRY], ranked((), 0.0), 1.0)
    source = "encoder resolution; the runs hold no repeated cycles"
    found = confirmed(claim, held_out(retuned=9.0, after=after, floor=0.5, floor_source=source))
    assert found.verdict == verdict
    assert (found.accepted is None) == (verdict == "unexplained")


def test_twins_share_what_they_win_and_others_do_not() -> None:
    scores = np.array([[0.0, 0.0], [0.5 * TWIN, 2.0 * TWIN], [1.0, 1.0]])
    assert _shared_wins(scores) == pytest.approx([1.5, 0.5, 0.0])


def ranked(ids: tuple[str, ...], probability: float, contains: tuple[str, ...] = ()) -> Ranked:
    hypothesis = SimpleNamespace(
        ids=ids,
        forms=ids,
        label=" + ".join(ids) or "retuned nominal",
        contained=frozenset(ids) | frozenset(contains),
        rough=False,
    )
    fit: Any = SimpleNamespace(hypothesis=hypothesis, held_out_rms=1.02 if ids else 9.0)
    return Ranked(fit=fit, probability=probability, gain=1.5, gain_interval=(1.0, 2.0))


DRY = ranked(("friction.coulomb",), 0.9)
FALLING = ("friction.stribeck",), 0.08, ("friction.coulomb",)


def test_a_richer_law_that_contains_the_best_one_is_no_rival() -> None:
    found = decide([DRY, ranked(*FALLING), ranked((), 0.0)], ranked((), 0.0), 1.0)
    assert found.verdict == "explained"
    assert decide([DRY, ranked(*FALLING[:2])], ranked((), 0.0), 1.0).verdict == "ambiguous"


def test_a_plainer_law_inside_the_best_one_is_taken_while_it_is_likely() -> None:
    best = ranked(FALLING[0], 0.9, FALLING[2])
    plainer = ranked(("friction.coulomb",), 0.08)
    found = decide([best, plainer], ranked((), 0.0), 1.0)
    assert found.accepted is plainer
    unlikely = ranked(("friction.coulomb",), 0.01)
    assert decide([best, unlikely], ranked((), 0.0), 1.0).accepted is best


def test_an_effect_without_which_validation_runs_are_predicted_better_is_doubted() -> None:
    both = ranked(("friction.coulomb", "load.bias"), 0.9)
    claim = replace(NO_GAP, verdict="explained", accepted=both)
    errors = {frozenset(r.fit.hypothesis.ids): e for r, e in ((both, 2.0), (DRY, 1.9))}
    assert doubted(claim, [both, DRY], errors) == (claim, [both, DRY])
    errors[frozenset(DRY.fit.hypothesis.ids)] = 1.0
    found, ranking = doubted(claim, [both, DRY], errors)
    assert (found.verdict, found.rivals) == ("ambiguous", (ranking[1],))
    assert [r.fit for r in ranking] == [both.fit, DRY.fit]
    half = (both.probability + DRY.probability) / 2
    assert [r.probability for r in ranking] == [half, half]


def test_an_effect_without_size_is_no_effect() -> None:
    def size(name: str) -> Any:
        return SimpleNamespace(name=name, starts=(0.0,))

    form = SimpleNamespace(effect="friction.coulomb", step=0.0, shapes={"width"}, least={})
    parameters = [size("level"), size("width")]
    fit: Any = SimpleNamespace(
        hypothesis=SimpleNamespace(forms=(form,), rough=False, kept=lambda form: parameters),
        keys=(("friction.coulomb", "level"), ("friction.coulomb", "width")),
        values=(1e-5, 0.02),
        deviation=(1e-4, 1e-3),
        by_key=lambda: dict(zip(fit.keys, fit.values)),
    )
    assert _holds_nothing(fit)
    fit.values = (1e-3, 0.02)
    assert not _holds_nothing(fit)
    form.least = {"level": 2e-3}  # a size that the model does not resolve
    assert _holds_nothing(fit)
    form.least = {}
    # Beside impacts no parameter has an uncertainty; that is no sign of size zero.
    fit.hypothesis.rough, fit.deviation = True, (np.nan, np.nan)
    assert not _holds_nothing(fit)


def test_a_delay_and_a_lag_are_twins_beside_impacts_and_where_either_would_do() -> None:
    def fit(*effects: str, rough: bool) -> Any:
        forms = [SimpleNamespace(effect=e, shifts=e.startswith("actuator")) for e in effects]
        return SimpleNamespace(hypothesis=SimpleNamespace(forms=forms, rough=rough))

    near, far = 0.5 * LATE_TWIN, 2.0 * LATE_TWIN
    for rough, apart, first in ((True, far, 0.8), (False, far, 0.8 + far), (False, near, 0.8)):
        found = [fit("clearance", "actuator.delay", rough=rough)]
        found += [fit("actuator.lag", "clearance", rough=rough), fit("clearance", rough=rough)]
        scores = np.array([[0.8 + apart] * 2, [0.8, 0.8], [0.79, 0.79]])
        shared = _best_of_twins(scores, _late_groups(found), found)
        np.testing.assert_array_equal(shared, [[first] * 2, [0.8, 0.8], [0.79, 0.79]])


def test_a_lag_in_a_log_whose_clock_was_off_is_doubted() -> None:
    late, on_time = ranked(("friction.coulomb", "actuator.lag"), 0.9), ranked(*FALLING[:2])
    for r in (late, on_time):
        ids = r.fit.hypothesis.ids
        r.fit.hypothesis.forms = [
            SimpleNamespace(effect=e, shifts=e.startswith("actuator")) for e in ids
        ]
    clock: Any = SimpleNamespace(effect="sensor.timing")
    offset: Any = SimpleNamespace(effect="sensor.offset")
    claim = replace(NO_GAP, verdict="explained", accepted=late)
    assert with_late_clock(claim, [late, DRY], [offset]) is claim
    found = with_late_clock(claim, [late, DRY], [clock])
    assert (found.verdict, found.rivals) == ("ambiguous", (DRY,))
    sound = replace(claim, accepted=on_time)
    assert with_late_clock(sound, [on_time], [clock]) is sound


def test_a_shared_effect_costs_twins_the_same() -> None:
    def fit(*effects: str, parameters: int, shift: float) -> Any:
        forms = [SimpleNamespace(effect=e, price=0.0) for e in effects]
        names = {e: ["p"] * (parameters if e == "friction.coulomb" else 1) for e in effects}
        hypothesis = SimpleNamespace(ids=effects, forms=forms, kept=lambda form: names[form.effect])
        return SimpleNamespace(hypothesis=hypothesis, residual=shift + np.ones(9), rms=1.0)

    gain = fit("actuator.torque_constant", "friction.coulomb", parameters=3, shift=0.0)
    scale = fit("sensor.scale", "friction.coulomb", parameters=1, shift=0.0)
    other = fit("load.bias", "friction.coulomb", parameters=1, shift=1.0)
    fits = [gain, scale, other]
    assert price(gain.hypothesis) > price(scale.hypothesis)
    assert _fair_price(gain, fits) == pytest.approx(price(scale.hypothesis))
    assert _fair_price(gain, [gain, other]) == price(gain.hypothesis)
