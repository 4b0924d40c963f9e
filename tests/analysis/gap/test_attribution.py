"""Attribution beside clearance, whose impacts no derivative sees through, on the independent machine."""

import pytest

from gapscope.analysis.blind_machine import write_case
from gapscope.analysis.gap.attribution import attribute
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import Predictor


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
