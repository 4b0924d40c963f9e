"""What a set of runs cannot separate or show, before any effect is looked for."""

import numpy as np
import pytest

from gapscope.analysis.gap.confusion import TOLD_APART, confusion
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machine import rms
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import Predictor


@pytest.fixture(scope="module")
def found(nominal_logset):
    machine, runs = read_machine(load_logset(nominal_logset))
    predictor = Predictor(machine, [run for run in runs if run.use == "fit"])
    retuned = fit(predictor, Hypothesis())
    residuals = predictor.residuals(retuned.hypothesis, [retuned.values], retuned.keys)[0]
    floor = rms(machine.floor(predictor.runs, residuals)[0])
    return confusion(predictor, retuned, machine.forms(predictor.runs), floor)


def test_one_gain_error_passes_for_one_scale_error_and_back(found):
    """tau -> g tau and reading -> reading / g are the same to first order for a linear drive."""
    assert ("actuator.torque_constant", "sensor.scale") in found.pairs
    assert ("sensor.scale", "actuator.torque_constant") in found.pairs


def test_different_mechanisms_are_told_apart(found):
    seen = set(found.pairs)
    for pair in (
        ("friction.coulomb", "load.bias"),
        ("friction.coulomb", "friction.viscous"),
        ("inertia.payload", "friction.coulomb"),
        ("actuator.delay", "inertia.payload"),
    ):
        assert pair not in seen


def test_matrix_is_a_remainder(found):
    """What another effect leaves of a fingerprint is never more than the fingerprint."""
    assert np.all(found.left <= found.size[:, None] * (1.0 + 1e-6) + 1e-9)
    assert np.all(np.diag(found.left) == 0.0)
    assert np.all(found.size >= 0.0)
    for effect in found.invisible:
        assert found.size[found.effects.index(effect)] < TOLD_APART
