"""Fits: a prediction that runs away is a failed hypothesis, not a number that breaks the ranking."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from gapscope.analysis.gap.fitting import _held_out, effective_samples, fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import DIVERGED, Predictor


def test_a_prediction_that_runs_away_is_bounded_and_does_not_converge(nominal_logset):
    machine, runs = read_machine(load_logset(nominal_logset))
    predictor = Predictor(machine, runs[:2])
    # Viscous friction far below zero feeds the motion: positions grow past all bounds.
    own = tuple(
        replace(p, starts=(-10.0,), lower=-11.0, upper=-9.0) if p.name.startswith("beta") else p
        for p in machine.own
    )
    wild = Predictor(replace(machine, own=own), runs[:2])
    found = fit(wild, Hypothesis())
    assert not found.converged
    assert np.all(np.abs(found.residual) <= DIVERGED * predictor.spread)
    json.dumps([found.rms, found.held_out_rms], allow_nan=False)


def test_a_step_without_a_run_is_shortened_until_it_fits_the_others():
    """The first run holds the value at zero; the others ask for 0.22, and a whole step overshoots to 0.4."""

    def residuals(x, which=range(3)):
        laws = [10.0 * x[0], np.exp(5.0 * x[0]) - 3.0, np.exp(5.0 * x[0]) - 3.0]
        return [np.full((4, 1), laws[i]) for i in which]

    problem = SimpleNamespace(
        predictor=SimpleNamespace(runs=list(range(3))),
        lower=np.array([-1e3]),
        upper=np.array([1e3]),
        runs=lambda points, runs=None: [
            residuals(x, range(3) if runs is None else runs) for x in points
        ],
    )
    x = np.zeros(1)
    jacobian = np.repeat([10.0, 5.0, 5.0], 4)[:, None]
    found = _held_out(problem, residuals(x), jacobian, x, np.zeros(1, dtype=bool))
    assert found[0] == pytest.approx(np.full((4, 1), 2.0), rel=1e-3)


def test_joints_are_counted_one_by_one_in_what_a_correlated_residual_is_worth():
    pole, samples = 0.9, 20_000
    noise = np.random.default_rng(2).standard_normal((samples, 2))
    red = lfilter([1.0], [1.0, -pole], noise, axis=0)
    worth = samples * (1.0 - pole) / (1.0 + pole)  # of a first-order process
    assert effective_samples(red[:, :1]) == pytest.approx(worth, rel=0.15)
    assert effective_samples(red) == pytest.approx(2.0 * worth, rel=0.15)
    assert effective_samples(noise) == pytest.approx(2.0 * samples, rel=0.05)
