"""A measured rotary pendulum: its control law, its friction and inertia, and free prediction."""

import os
from pathlib import Path

import numpy as np
import pytest

from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import furuta, read_machine
from gapscope.models.joint import VISCOUS

DATA = os.environ.get("GAPSCOPE_DATA")
needs_data = pytest.mark.skipif(DATA is None, reason="GAPSCOPE_DATA is not set: no measured logs")


@pytest.fixture(scope="module")
def pendulum():
    return read_machine(load_logset(Path(DATA) / "qube_furuta"))


@needs_data
def test_the_stated_law_reproduces_every_logged_voltage(pendulum):
    machine, runs = pendulum
    checks = machine.replays(runs)
    assert len(checks) == 12
    assert max(c.disagreement for c in checks) < 1e-3


@needs_data
def test_less_damping_and_a_heavier_arm_predict_held_out_motion_better(pendulum):
    """The values are those that a diagnosis of runs 01-08 ends with; the runs here are 09-12."""
    machine, runs = pendulum
    held_out = [run for run in runs if run.use == "validate"]
    nominal = machine.build(machine.nominal())
    values = {**machine.nominal(), "k": 0.04326, "m": 0.02356, "L_p": 0.1251}
    found = machine.build(values)
    found.joints.law[:, VISCOUS] += -0.001385, -0.0005
    found.phi[0] += 5.9e-5

    def error(plant):
        return np.sqrt(np.mean([np.mean(machine.predict(r, plant) ** 2) for r in held_out]))

    assert error(found) < 0.15 * error(nominal)
    before = furuta.horizon_errors(held_out, nominal, 0.048)
    after = furuta.horizon_errors(held_out, found, 0.048)
    assert np.all(after < 0.4 * before)


@needs_data
@pytest.mark.slow
def test_the_diagnosis_blames_printed_damping_and_the_inertia_of_the_arm():
    from gapscope.analysis.gap.diagnosis import diagnose

    found = diagnose(Path(DATA) / "qube_furuta")
    assert found.verdict.verdict == "explained"
    ids = {effect["id"] for effect in found.to_json()["effects"]}
    assert ids == {"friction.viscous", "inertia.payload"}
    assert found.shrinkage.percent > 80.0
