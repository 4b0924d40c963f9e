"""Attribution of pairs: twins, and clearance, whose impacts no derivative sees through."""

import pytest

from gapscope.analysis.blind_machine import write_case
from gapscope.analysis.gap.attribution import attribute
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import Predictor
from gapscope.models.drive import BACKWARD, FORWARD, GAIN, WIDTH

from .conftest import write_logset


def ranking(folder, seed, index, effects):
    """Hypotheses of some effects on a case of a tuning seed, best first, and the answer."""
    answer = write_case(seed, index, folder)
    machine, runs = read_machine(load_logset(folder))
    runs = [run for run in runs if run.use == "fit"]
    predictor = Predictor(machine, runs)
    forms = [form for form in machine.forms(runs) if form.effect in effects]
    retuned = fit(predictor, Hypothesis())
    found = attribute(predictor, retuned, forms, 0.0, 0, lambda text: None)
    return [frozenset(r.fit.hypothesis.ids) for r in found], frozenset(answer["answer"])


@pytest.mark.slow
def test_clearance_is_found_beside_a_smooth_effect(tmp_path):
    tried = {"actuator.ripple", "friction.viscous", "transmission.backlash"}
    found, answer = ranking(tmp_path, 8, 21, tried)
    assert answer == {"actuator.ripple", "transmission.backlash"}
    assert found[0] == answer
    assert {"actuator.ripple"} in found  # the smaller ones are in the ranking, too


@pytest.mark.slow
def test_a_late_command_beside_clearance_is_a_delay_or_a_lag(tmp_path):
    tried = {"actuator.lag", "actuator.delay", "transmission.backlash"}
    found, answer = ranking(tmp_path, 16, 29, tried)
    assert answer == {"actuator.lag", "transmission.backlash"}
    assert set(found[:2]) == {answer, frozenset({"actuator.delay", "transmission.backlash"})}


def fitted(folder):
    """Predictor of the runs to fit to, and the retuned model."""
    machine, runs = read_machine(load_logset(folder))
    predictor = Predictor(machine, [run for run in runs if run.use == "fit"])
    return predictor, fit(predictor, Hypothesis())


def forms_of(predictor, *effects):
    return [f for f in predictor.machine.forms(predictor.runs) if f.effect in effects]


def gain_and_dry_friction(plant):
    plant.shaft[:, GAIN] = 1.25
    plant.element[:2, [FORWARD, BACKWARD]] = 0.1
    plant.element[:2, WIDTH] = 0.03


def test_a_gain_and_a_scale_are_not_told_apart_beside_another_effect_either(tmp_path):
    """Selection goes on from one of the two only; from which is chance."""
    predictor, retuned = fitted(write_logset(tmp_path / "set", gain_and_dry_friction))
    tried = ("actuator.torque_constant", "sensor.scale", "friction.coulomb")
    forms = [f for f in forms_of(predictor, *tried) if not f.refined]
    ranked = attribute(predictor, retuned, forms, 0.0, 0, lambda text: None)
    best = {frozenset(r.fit.hypothesis.ids): r.probability for r in ranked[:2]}
    pairs = [{"actuator.torque_constant", tried[2]}, {"sensor.scale", tried[2]}]
    assert {frozenset(pair): pytest.approx(0.5, abs=0.01) for pair in pairs} == best


def test_what_an_unfinished_search_gained_on_held_out_runs_is_not_passed_on(tmp_path):
    """Its held-out parameters, one step further, are far better than its own."""
    predictor, retuned = fitted(write_logset(tmp_path / "set", gain_and_dry_friction))
    (gain, _), (smooth, dahl, *_) = (
        forms_of(predictor, effect) for effect in ("actuator.torque_constant", "friction.coulomb")
    )
    begun = fit(predictor, Hypothesis(forms=(gain, smooth)), retuned, steps=1)
    assert not begun.finished
    assert begun.held_out_rms < 0.2 * begun.rms
    child = fit(predictor, Hypothesis(forms=(gain, dahl)), begun, screen=1.0)
    assert not child.searched
    assert child.held_out_rms > 0.9 * child.rms
