"""The instrument finds a planted effect, where it acts, and says nothing where there is nothing."""

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.attribution import attribute
from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.effects import Effect, catalogue, register
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.inverse_model import inverse_model
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import Predictor
from gapscope.models.drive import (
    BACKWARD,
    BIAS,
    DELAY,
    FORWARD,
    RIPPLE_COS,
    RIPPLE_WAVENUMBER,
    WIDTH,
)

from .conftest import write_logset


def coulomb_right(plant):
    plant.element[1, [FORWARD, BACKWARD]] = 0.2
    plant.element[1, WIDTH] = 0.3


def bias(plant):
    plant.shaft[:, BIAS] = 0.1, -0.1


def delay(plant):
    plant.shaft[:, DELAY] = 1e-3


def ripple(plant):
    plant.shaft[:, RIPPLE_WAVENUMBER] = 8.0
    plant.shaft[0, RIPPLE_COS] = 0.26


@pytest.mark.parametrize(
    ("change", "effect", "where", "parameter", "value", "tolerance"),
    [
        # Tolerances are three times the interval's half width of a fit to this noise, rounded up.
        (coulomb_right, "friction.coulomb", {"elements": ["right"]}, "level_right", 0.2, 2e-3),
        (bias, "load.bias", {"joints": ["left", "right"]}, "bias_left", 0.1, 2e-3),
        (ripple, "actuator.ripple", {"joints": ["left"]}, "cos_left", 0.26, 2e-3),
        (delay, "actuator.delay", {"joints": ["left", "right"]}, "delay", 1e-3, 1e-4),
    ],
)
def test_a_planted_effect_is_found_with_place_and_size(
    tmp_path, change, effect, where, parameter, value, tolerance
):
    result = diagnose(write_logset(tmp_path / "set", change)).to_json()
    twins = ["actuator.lag"] if effect == "actuator.delay" else []  # a delay of one sample
    assert result["verdict"] == ("ambiguous" if twins else "explained")
    assert [e["id"] for e in result["effects"]] == [effect, *twins]
    assert result["effects"][0]["where"] == where
    found = result["effects"][0]["parameters"][parameter]["value"]
    assert found == pytest.approx(value, abs=tolerance)
    assert result["shrinkage"]["percent"] > 95.0
    assert result["shrinkage"]["ci95"][0] > 90.0
    best = next(r for r in result["ranking"] if r["ids"] == [effect])
    assert best["estimates"][effect][parameter]["value"] == pytest.approx(found)
    assert best["signature_agreement"] > 0.9


def test_two_runs_are_enough_where_only_one_shows_the_effect(tmp_path):
    """Whole runs held out would leave the added mass to the run that does not move it."""

    def payload(plant):
        inertia = np.linalg.inv(plant.inertia_inverse) + 3e-4 * np.ones((2, 2))
        plant.inertia_inverse[:] = np.linalg.inv(inertia)

    folder = write_logset(tmp_path / "set", payload)
    document = yaml.safe_load((folder / "logset.yaml").read_text())
    document["runs"] = [run for run in document["runs"] if run["file"] != "run2.csv"]
    assert [run["motion"] for run in document["runs"] if run["use"] == "fit"] == [
        "translation",
        "rotation",
    ]
    (folder / "logset.yaml").write_text(yaml.safe_dump(document))
    result = diagnose(folder).to_json()
    assert result["verdict"] == "explained"
    assert [e["id"] for e in result["effects"]] == ["inertia.payload"]


def test_no_gap_is_said_where_there_is_none(nominal_logset):
    result = diagnose(nominal_logset).to_json()
    assert (result["verdict"], result["effects"]) == ("no_gap", [])


def test_the_contract_of_diagnosis_json(nominal_logset, tmp_path):
    path = diagnose(nominal_logset).save(tmp_path / "out")
    result = json.loads(path.read_text())
    assert {"verdict", "effects", "ranking", "location", "shrinkage", "warnings"} <= set(result)
    for name in ("signals", "joints", "regimes", "bands"):
        assert sum(entry["share"] for entry in result["location"][name]) == pytest.approx(1.0)
    assert {"metric", "before", "retuned", "after", "floor", "percent", "ci95"} <= set(
        result["shrinkage"]
    )
    assert all({"ids", "probability", "validation_error"} <= set(r) for r in result["ranking"])
    assert sum(r["probability"] for r in result["ranking"]) == pytest.approx(1.0, abs=1e-3)


def test_the_same_seed_gives_the_same_result(nominal_logset):
    first, second = (diagnose(nominal_logset, seed=3).to_json() for _ in range(2))
    for result in (first, second):
        result["provenance"].pop("seconds")
    assert first == second


def test_registering_a_taken_effect_is_refused():
    taken = next(iter(catalogue().values()))
    with pytest.raises(ValueError, match=taken.id):
        register(Effect(id=taken.id, summary="", forms=lambda machine, scales: [], signature=""))


OPEN = {
    "none": ("no_gap", [], None),
    "viscous": ("explained", ["friction.viscous"], None),
    "coulomb": ("explained", ["friction.coulomb"], {"elements": ["left", "right"]}),
    "coulomb_left": ("explained", ["friction.coulomb"], {"elements": ["left"]}),
    "bias": ("explained", ["load.bias"], {"joints": ["left", "right"]}),
    "payload": ("explained", ["inertia.payload"], None),
    "delay": ("ambiguous", ["actuator.delay", "actuator.lag"], None),  # one sample: twins
    "backlash": ("explained", ["transmission.backlash"], None),
    "coulomb_and_bias": ("explained", ["friction.coulomb", "load.bias"], None),
}


@pytest.mark.parametrize("name", sorted(OPEN))
def test_open_sets_of_the_independent_simulator(open_sets, name):
    """Labels are typed in here from the sets' ``answer``, which the instrument never sees."""
    verdict, ids, where = OPEN[name]
    result = diagnose(open_sets / name).to_json()
    assert result["verdict"] == verdict
    assert sorted(e["id"] for e in result["effects"]) == ids
    if where:
        assert result["effects"][0]["where"] == where
    if ids:
        assert result["shrinkage"]["percent"] > (60.0 if name == "backlash" else 98.0)


def test_emps_dry_friction_and_offset(shared_data):
    """Measured: Coulomb friction and offset near the published fit (Janot et al. 2019)."""
    result = diagnose(shared_data / "emps").to_json()
    effects = {e["id"]: e["parameters"] for e in result["effects"]}
    assert set(effects) == {"friction.coulomb", "load.bias"}
    assert effects["friction.coulomb"]["level_axis"]["value"] == pytest.approx(20.39, rel=0.05)
    assert effects["load.bias"]["bias_axis"]["value"] == pytest.approx(-3.16, rel=0.05)
    loops = result["shrinkage"]["closed_loop"]
    assert (
        loops["after"]["relative_command_error"] < 0.059 < loops["before"]["relative_command_error"]
    )
    assert result["shrinkage"]["ci95"][0] > 85.0


def test_emps_inverse_model_errors_fall_as_published(shared_data):
    """Relative force errors of the issue's measured sequence, each within 6 % of itself."""
    machine, runs = read_machine(load_logset(shared_data / "emps"))
    errors = [s.relative_error for s in inverse_model(machine, runs)]
    assert errors == pytest.approx([0.695, 0.180, 0.072, 0.041, 0.032], rel=0.06)


def test_runs_in_which_nothing_moves_are_refused_in_words(nominal_logset):
    machine, runs = read_machine(load_logset(nominal_logset))
    still = [replace(run, reference_rate=0.0 * run.reference_rate) for run in runs]
    with pytest.raises(InputError, match="the reference never moves"):
        machine.forms(still)


def test_a_lone_run_that_moves_only_where_it_is_held_back_is_refused(nominal_logset, tmp_path):
    folder = tmp_path / "set"
    folder.mkdir()
    document = yaml.safe_load((nominal_logset / "logset.yaml").read_text())
    lone = next(run for run in document["runs"] if run["use"] == "fit")
    document["runs"] = [lone]
    (folder / "logset.yaml").write_text(yaml.safe_dump(document))
    header, *_ = (nominal_logset / lone["file"]).read_text().splitlines()
    moving = np.loadtxt(nominal_logset / lone["file"], delimiter=",", skiprows=1)
    rest = np.repeat(moving[:1], 3 * len(moving), axis=0)
    rest[:, 5:] = 0.0  # torques
    table = np.vstack([rest, moving])
    table[:, 0] = (moving[1, 0] - moving[0, 0]) * np.arange(len(table))
    np.savetxt(folder / lone["file"], table, delimiter=",", comments="", fmt="%.6f", header=header)
    with pytest.raises(InputError, match=r"never change.*held back for validation, and only it"):
        diagnose(folder)


def test_a_retuned_model_that_predicts_nothing_stays_what_others_are_measured_by(nominal_logset):
    machine, runs = read_machine(load_logset(nominal_logset))
    predictor = Predictor(machine, [run for run in runs if run.use == "fit"])
    useless = replace(fit(predictor, Hypothesis()), converged=False)
    (only,) = attribute(predictor, useless, [], 1e-3, 0, lambda text: None)
    assert only.fit.hypothesis.forms == ()
