"""Every form of the catalogue: no effect at zero, a visible one away from it, a place that exists."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from gapscope.analysis.blind_machine import write_case
from gapscope.analysis.gap import effects
from gapscope.analysis.gap.effects import catalogue, scales_of
from gapscope.analysis.gap.effects.two_inertia import MOST_STEPS, ON_LOAD, split
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import Predictor


@pytest.fixture(scope="module")
def case(nominal_logset):
    machine, runs = read_machine(load_logset(nominal_logset))
    return machine, Predictor(machine, runs[:1]), machine.forms(runs)


def residual(case, form, values):
    machine, predictor, _ = case
    own = {("", name): v for name, v in machine.nominal().items()}
    point = own | {(form.effect, name): v for name, v in values.items()}
    hypothesis = Hypothesis(forms=(form,))
    return predictor.residuals(hypothesis, [np.array(list(point.values()))], list(point))[0][0]


def nominal_residual(case):
    machine, predictor, _ = case
    own = machine.nominal()
    keys = [("", name) for name in own]
    return predictor.residuals(Hypothesis(), [np.array(list(own.values()))], keys)[0][0]


def test_every_additive_form_is_nothing_at_zero_and_something_away_from_it(case):
    plain = nominal_residual(case)
    checked = 0
    for form in case[2]:
        zero = {p.name: p.starts[0] for p in form.parameters}
        if any(v != 0.0 for name, v in zero.items() if name not in form.shapes):
            continue
        np.testing.assert_allclose(residual(case, form, zero), plain, rtol=0, atol=1e-12)
        # An asymmetry is a share of a level: with levels at work it must be seen, too.
        active = {
            p.name: 0.1 * p.scale if v == 0.0 else v for p, v in zip(form.parameters, zero.values())
        }
        assert np.max(np.abs(residual(case, form, active) - plain)) > 1e-7, form.name
        checked += 1
    assert checked > 10


def test_friction_shared_between_motor_and_load_adds_up(case):
    """A stiff coupling without clearance feels no difference: the whole friction stays the same."""
    machine, predictor, _ = case
    residuals = []
    for share in (0.0, 0.4, 1.0):
        plant = machine.build(machine.nominal())
        split(
            plant, machine, share=0.7, stiffness=2000.0, damping_ratio=1.0, gap=0.0, dt=1e-3,
            load_friction=share,
        )  # fmt: skip
        residuals.append(machine.predict(predictor.runs[0], plant.finished()))
    size = np.sqrt(np.mean(residuals[0] ** 2))
    for other in residuals[1:]:
        assert 0.0 < np.sqrt(np.mean((other - residuals[0]) ** 2)) < 0.05 * size


def test_every_form_names_existing_places(case):
    machine, _, forms = case
    known = {*machine.joints, *machine.elements, *(axis.name for axis in machine.payload)}
    for form in forms:
        where = form.where([p.name for p in form.parameters])
        assert where
        assert {place for places in where.values() for place in places} <= known, form.name


@pytest.fixture(scope="module")
def cold_slider(tmp_path_factory):
    """A slider of the independent machine whose friction fades as it warms up, with its answer."""
    folder = tmp_path_factory.mktemp("cold")
    answer = write_case(2, 28, folder)
    machine, runs = read_machine(load_logset(folder))
    return machine, runs, answer["parameters"]["friction.thermal_drift"]


def test_every_form_predicts_a_slider_where_a_search_moves_it(cold_slider):
    machine, runs, _ = cold_slider
    predictor, forms = Predictor(machine, runs[:1]), machine.forms(runs)
    for form in forms:
        for moved in form.parameters:
            values = {p.name: p.starts[0] for p in form.parameters}
            values[moved.name] += 1e-3 * moved.scale
            found = residual((machine, predictor, forms), form, values)
            assert np.max(np.abs(found)) < 0.01 * np.ptp(runs[0].position), (form.name, moved.name)


def test_encoders_behind_a_spring_are_predicted_by_their_own_form_alone(cold_slider):
    machine, runs, _ = cold_slider
    plants = {}
    for form in machine.forms(runs):
        if form.effect == "transmission.compliance":
            plant = machine.build(machine.nominal())
            form.apply(
                plant, {"compliance": 2e-7, "motor_share": 0.5, "damping_ratio": 0.1}
            )  # a resonance near 50 Hz
            plants[form.name] = plant.finished()
    position, command = machine.simulate(
        replace(runs[0], lsb=0.0), plants["two inertias" + ON_LOAD]
    )
    logged = replace(runs[0], position=position, command=command)
    size = {name: np.abs(machine.predict(logged, plant)).max() for name, plant in plants.items()}
    assert size["two inertias" + ON_LOAD] < 1e-9
    assert size["two inertias"] > 1e-6


def test_warm_up_is_recovered_from_runs_minutes_apart(cold_slider):
    machine, runs, truth = cold_slider
    predictor = Predictor(machine, [run for run in runs if run.use == "fit"])
    (form,) = (f for f in machine.forms(runs) if f.effect == "friction.thermal_drift")
    found = fit(predictor, Hypothesis(forms=(form,)), fit(predictor, Hypothesis())).by_key()
    for name, expected in (
        ("cold_viscous_share", truth["viscous_excess"]),
        ("cold_level", truth["coulomb_N"]),
        ("warm_up", truth["time_constant_s"]),
    ):  # the nominal model is off by up to 3 %, and the true dry friction is a step
        assert found[form.effect, name] == pytest.approx(expected, rel=0.05), name


def test_one_file_is_one_effect_and_says_its_id():
    import gapscope.analysis.gap.effects as package

    files = {p.stem for p in Path(package.__file__).parent.glob("*_*.py")} - {
        "dry_friction",
        "two_inertia",
        "carrier_forms",
        "__init__",
    }
    built_in = {id_.replace(".", "_") for id_ in catalogue() if not id_.startswith("my.")}
    assert files == built_in


def test_the_effect_that_the_readme_shows_says_where_it_acts(case):
    machine, predictor, _ = case
    text = (Path(__file__).parents[3] / "analysis" / "gap" / "effects" / "README.md").read_text()
    (block,) = re.findall(r"```python\n(.*?)```", text, re.S)
    names = {}
    try:
        exec(block, names)
        (form,) = names["forms"](machine, scales_of(predictor.runs))
        place = form.where([p.name for p in form.parameters])
        found = fit(predictor, Hypothesis(forms=(form,)))
    finally:
        effects._registered.pop("my.load", None)
    assert set(place["joints"]) <= set(machine.joints)
    assert found.converged


def test_a_load_of_negative_inertia_is_a_prediction_that_fails_and_no_error(case):
    """As where torques are logged with the other sign, and a fit makes the inertia negative."""
    machine, predictor, forms = case
    form = next(f for f in forms if f.effect == "transmission.compliance")
    own = machine.nominal()
    values = {("", name): v for name, v in own.items()} | {("", "inertia_translation"): -1e-4}
    values |= {(form.effect, p.name): p.starts[0] for p in form.parameters}
    values[form.effect, "compliance"] = 1e-3
    hypothesis = Hypothesis(forms=(form,))
    plant = hypothesis.plant(machine, values)
    assert 1 <= plant.substeps <= MOST_STEPS
    found = predictor.residuals(hypothesis, [np.array(list(values.values()))], list(values))[0][0]
    assert np.all(np.isfinite(found))
