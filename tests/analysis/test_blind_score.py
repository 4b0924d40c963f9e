"""The score on diagnoses made by hand, whose confusion, rates and calibration are known."""

import json

import numpy as np
import pytest

from gapscope.analysis import blind_rates, blind_report, blind_score, blind_statistics


def made(
    kind,
    truth,
    verdict,
    ids=(),
    *,
    probability=None,
    second=None,
    strength=20.0,
    error=None,
    **more,
):
    """An outcome from an answer and a diagnosis in the published layout."""
    truth = [truth] if isinstance(truth, str) else list(truth)
    ids = [ids] if isinstance(ids, str) else list(ids)
    ranking = [{"ids": ids, "probability": probability}] if ids else []
    ranking += [{"ids": [second], "probability": 0.0}] if second else []
    answer = {
        "name": "case",
        "kind": kind,
        "answer": truth,
        "cause": truth,
        "strength": {"all": strength},
        "parameters": more.get("true", {}),
        "attainable_percent": 98.0,
    }
    effects = [{"id": i, "parameters": more.get("found", {}).get(i, {})} for i in ids]
    diagnosis = {
        "verdict": verdict,
        "effects": (effects if verdict == "explained" else []) + more.get("findings", []),
        "ranking": ranking,
        "shrinkage": {"percent": 95.0},
    }
    return blind_score.outcome(answer, {"diagnosis": diagnosis, "error": error, "seconds": 1.0})


BIAS, DRY, DELAY, LAG = "load.bias", "friction.coulomb", "actuator.delay", "actuator.lag"


def test_what_each_verdict_names():
    assert made("single", BIAS, "explained", BIAS).right
    assert made("none", (), "no_gap").right
    assert made("off_library", "unknown", "unexplained").right
    twin = made("single", LAG, "ambiguous", DELAY, second=LAG, probability=0.5)
    assert (twin.right, twin.right_in_two, twin.claimed) == (False, True, False)
    assert twin.names_both_late
    assert not made("single", LAG, "ambiguous", DELAY, second=BIAS).names_both_late
    assert not made("single", BIAS, "ambiguous", DELAY, second=LAG).names_both_late
    assert not made("single", LAG, "explained", DELAY, second=LAG).names_both_late
    offset = [{"id": "sensor.offset", "parameters": {}, "evidence": "replayed"}]
    twin = made(
        "double",
        (LAG, "sensor.offset"),
        "ambiguous",
        LAG,
        second=DELAY,
        probability=0.9,
        findings=offset,
    )
    assert (twin.right, twin.claimed, twin.confidence) == (True, False, 0.9)
    pair = made("double", (BIAS, DRY), "explained", BIAS)
    assert (pair.right, pair.claimed) == (False, True)
    crashed = made("single", BIAS, "explained", BIAS, error="ValueError: x")
    assert (crashed.verdict, crashed.right, crashed.claimed) == ("failed", False, False)
    assert made("single", BIAS, "certain", BIAS).verdict == "failed"


def test_a_case_is_visible_if_its_faintest_effect_is():
    assert made("single", BIAS, "no_gap", strength=5.0).visible
    assert not made("single", BIAS, "no_gap", strength=4.9).visible
    answer = {
        "name": "case", "kind": "double", "answer": [BIAS, DRY], "cause": [BIAS, DRY],
        "strength": {"all": 50.0, BIAS: 49.0, DRY: 2.0}, "parameters": {},
    }  # fmt: skip
    result = {"diagnosis": {"verdict": "no_gap"}, "error": None, "seconds": 1.0}
    assert not blind_score.outcome(answer, result).visible


def test_confusion_counts():
    outcomes = [
        *[made("single", BIAS, "explained", BIAS)] * 3,
        made("single", BIAS, "explained", DRY),
        made("single", DRY, "ambiguous", DRY, second=BIAS),
        made("none", (), "explained", DRY),
        made("none", (), "no_gap"),
        made("off_library", "unknown", "unexplained"),
        made("off_library", "unknown", "explained", (BIAS, DRY)),
        made("double", (BIAS, DRY), "explained", (BIAS, DRY)),
    ]
    truths, said, counts = blind_score.confusion(outcomes)
    table = {(t, p): counts[i, j] for i, t in enumerate(truths) for j, p in enumerate(said)}
    assert {k: v for k, v in table.items() if v} == {
        (BIAS, BIAS): 3,
        (BIAS, DRY): 1,
        (DRY, "ambiguous"): 1,
        ("no_gap", DRY): 1,
        ("no_gap", "no_gap"): 1,
        ("unknown", "unknown"): 1,
        ("unknown", "several"): 1,
    }


def test_rates_of_a_known_run():
    outcomes = [
        *[made("single", BIAS, "explained", BIAS)] * 6,
        *[made("single", DRY, "explained", BIAS, second=DRY)] * 2,
        *[made("double", (BIAS, DRY), "explained", (BIAS, DRY))] * 1,
        *[made("double", (BIAS, DRY), "explained", BIAS)] * 1,
        *[made("none", (), "no_gap")] * 9,
        *[made("none", (), "explained", DRY)] * 1,
        *[made("off_library", "unknown", "unexplained")] * 3,
        *[made("off_library", "unknown", "explained", DRY)] * 1,
        *[made("single", DRY, "no_gap", strength=1.0)] * 5,
        *[made("single", LAG, "ambiguous", DELAY, second=LAG)] * 2,
    ]
    numbers = blind_rates.summary(outcomes)
    expected = {
        "top1": 7 / 12,
        "top1_late": 9 / 12,
        "top2": 11 / 12,
        "top1_single": 0.6,
        "top1_double": 0.5,
        "double_at_least_one": 1.0,
        "double_nothing_wrong": 1.0,
        "false_alarms": 0.1,
        "off_library_withheld": 0.75,
        "off_library_false": 0.25,
        "abstentions": 2 / 12,
        "top1_faint": 0.0,
    }
    assert {key: numbers[key].value for key in expected} == pytest.approx(expected)
    assert numbers["by_mechanism"][DRY]["top1"].value == 0.0
    assert numbers["by_mechanism"][DRY]["top2"].value == 1.0
    assert numbers["by_mechanism"][DRY]["faint"] == 5


def test_wilson_interval_of_the_textbook():
    """Nine of ten: Wilson 95 % is [0.596, 0.982] (Brown, Cai, DasGupta 2001, eq. 4)."""
    e = blind_statistics.proportion([True] * 9 + [False])
    assert (e.value, e.low, e.high) == pytest.approx((0.9, 0.5958, 0.9821), abs=1e-4)


def test_calibration_error_by_hand():
    """0.95 said, right 8 of 10; 0.55 said, right 5 of 10: (0.15 + 0.05)/2."""
    rows = [(0.95, 1.0)] * 8 + [(0.95, 0.0)] * 2 + [(0.55, 1.0)] * 5 + [(0.55, 0.0)] * 5
    assert blind_statistics.calibration_error(np.array(rows)) == pytest.approx(0.1)
    assert blind_statistics.calibration_error(np.array([(1.0, 1.0)] * 4)) == 0.0


def test_calibration_error_of_a_calibrated_forecaster_vanishes():
    """n = 20000 seeded: the bias of binned |accuracy - confidence| is below 10/sqrt(8 n pi) ~ 0.5 %."""
    rng = np.random.default_rng(1)
    confidence = rng.random(20000)
    rows = np.column_stack([confidence, rng.random(20000) < confidence])
    assert blind_statistics.calibration_error(rows) < 0.015
    shifted = np.column_stack([np.minimum(confidence + 0.2, 1.0), rows[:, 1]])
    assert blind_statistics.calibration_error(shifted) > 0.1


def test_risk_coverage_by_hand():
    outcomes = [
        made("single", BIAS, "explained", BIAS, probability=0.9),
        made("single", BIAS, "explained", DRY, probability=0.8),
        made("single", BIAS, "explained", BIAS, probability=0.8),
        made("single", BIAS, "unexplained"),
        made("none", (), "explained", DRY, probability=1.0),
    ]
    assert blind_score.risk_coverage(outcomes) == [(0.25, 0.0), (0.75, pytest.approx(1 / 3))]


def test_parameter_errors_compare_what_is_alone_with_its_unit():
    o = made(
        "single", BIAS, "explained", BIAS,
        true={BIAS: {"torque_Nm": 0.2, "where": "left", "level_rad": 1.0, "mass_kg": 0.0}},
        found={
            BIAS: {
                "load": {"value": -0.22, "ci95": [-0.24, -0.2], "unit": "N m"},
                "left": {"value": 1.0, "unit": "rad"},
                "right": {"value": 3.0, "unit": "rad"},
                "mass": {"value": 3.0, "unit": "kg"},
            }
        },
    )  # fmt: skip
    errors = blind_rates.summary([o])["parameters"]
    assert list(errors) == [
        f"{BIAS} torque_Nm"
    ]  # two angles, and a true mass of none, are left out
    assert errors[f"{BIAS} torque_Nm"].value == pytest.approx(0.1)  # a load opposes the torque


def test_the_report_states_use_targets_and_mistakes(tmp_path):
    outcomes = [
        *[made("single", BIAS, "explained", BIAS, probability=0.9)] * 3,
        made("single", DRY, "explained", BIAS, probability=0.6),
        made("none", (), "no_gap"),
        made("off_library", "unknown", "unexplained"),
    ]
    content = blind_report.write(outcomes, seed=1000, digest="ab" * 32, out=tmp_path)
    assert content == json.loads((tmp_path / "blind.json").read_text())
    text = (tmp_path / "blind.md").read_text()
    assert "seed 1000 (report)" in text
    assert "| top-1, visible effects | 75 % [30, 95] | >= 95 % | 4 | no |" in text
    assert f"| case | {DRY} | 20.0 | explained | {BIAS} |" in text
    figures = {p.name for p in tmp_path.glob("*.png")}
    assert figures == {"confusion.png", "calibration.png", "risk_coverage.png", "shrinkage.png"}
