"""Fits: a prediction that runs away is a failed hypothesis, not a number that breaks the ranking."""

import json
from dataclasses import replace

import numpy as np

from gapscope.analysis.gap.fitting import fit
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
