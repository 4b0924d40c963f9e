"""Periods of a ripple that no list holds, found in what a model leaves."""

import numpy as np
import pytest

from gapscope.analysis.blind_machine import write_case
from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.effects.actuator_ripple import FEWEST_PERIODS, PERIODS_SAMPLES
from gapscope.analysis.gap.effects.base import scales_of
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import Predictor
from gapscope.analysis.gap.scan import Spectra
from gapscope.models import drive

from .conftest import write_logset

CASES = (
    (27, 68),
    (28, 58),
)  # of tuning seeds: a screw drive, 1.85 periods a turn, and a slider, 30.5 mm
ORDER = 7.3  # per radian of a shaft, far from the listed 6 and 8


@pytest.fixture(scope="module")
def rippled(tmp_path_factory):
    def change(plant):
        plant.shaft[:, drive.RIPPLE_WAVENUMBER] = ORDER
        plant.shaft[0, drive.RIPPLE_SIN] = 0.05

    folder = write_logset(tmp_path_factory.mktemp("ripple") / "set", change)
    machine, runs = read_machine(load_logset(folder))
    return machine, [run for run in runs if run.use == "fit"]


def test_the_period_is_seen_in_the_residual_and_measured_by_the_fit(rippled):
    machine, runs = rippled
    predictor = Predictor(machine, runs)
    retuned = fit(predictor, Hypothesis())
    spectra = Spectra(predictor, retuned)
    forms = spectra.forms_beside(retuned)
    fits = [fit(predictor, Hypothesis(forms=(form,)), retuned) for form in forms]
    best = min(fits, key=lambda f: f.rms)
    assert best.rms < 0.5 * retuned.rms
    values = best.by_key()
    assert values["actuator.ripple", "period"] == pytest.approx(2.0 * np.pi / ORDER, rel=2e-3)
    assert values["actuator.ripple", "sin_left"] == pytest.approx(0.05, rel=0.05)
    assert abs(values.get(("actuator.ripple", "sin_right"), 0.0)) < 0.01
    assert spectra.forms_beside(best) == []  # beside itself it is not looked for


def test_a_spectrum_is_the_share_of_the_loss_that_a_fit_at_that_period_removes(rippled):
    machine, runs = rippled
    predictor = Predictor(machine, runs)
    retuned = fit(predictor, Hypothesis())
    (scan,) = machine.scans(runs)
    falls = Spectra(predictor, retuned).falls("actuator.ripple", retuned)
    assert falls.shape == scan.values.shape
    highest = int(np.argmax(falls))
    assert scan.values[highest] == pytest.approx(2.0 * np.pi / ORDER, rel=0.02)
    form = scan.form(float(scan.values[highest]))
    held = fit(predictor, Hypothesis(forms=(form,)).drop((form.effect, "period")), retuned)
    assert falls[highest] == pytest.approx(1.0 - (held.rms / retuned.rms) ** 2, abs=0.02)


def test_a_law_with_few_periods_in_the_travel_is_no_ripple(rippled):
    """A spring is one smooth law over the travel; a ripple that imitates it would be a false finding."""
    machine, runs = rippled
    (scan,) = machine.scans(runs)
    scales = scales_of(runs)
    assert max(scan.values) == pytest.approx(scales.travel / FEWEST_PERIODS)
    assert min(scan.values) > scales.rate * scales.dt * PERIODS_SAMPLES / 1.01


@pytest.mark.slow
def test_an_unlisted_period_on_the_independent_machine_is_named(tmp_path):
    for seed, index in CASES:
        answer = write_case(seed, index, tmp_path / str(index))
        assert answer["answer"] == ["actuator.ripple"]
        found = diagnose(tmp_path / str(index))
        assert [e["id"] for e in found.to_json()["effects"]] == ["actuator.ripple"], index
