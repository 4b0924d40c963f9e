"""The floor: what does not repeat, and whether the encoder's noise accounts for it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.signal import lfilter

from gapscope.analysis.gap.floor import noise_floor, out_of_step, quantisation_floor
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.verdict import OUT_OF_STEP, Verdict, in_step

BANDWIDTH = 100.0  # rad/s
SEEDS = range(20)


@pytest.fixture(scope="module")
def run(nominal_logset):
    return read_machine(load_logset(nominal_logset))[1][0]


def prediction_error(run, noise):
    """What a position signal (samples, n) does to the prediction of a right model."""
    pole = np.exp(-BANDWIDTH * run.dt)
    return lfilter([1.0, -2.0, 1.0], [1.0, -2.0 * pole, pole**2], noise, axis=0)


def test_encoder_noise_keeps_below_the_limit(run):
    ratios = [
        out_of_step(
            [run],
            [prediction_error(run, np.random.default_rng(s).normal(0, 1e-4, run.position.shape))],
            BANDWIDTH,
        )
        for s in SEEDS
    ]
    assert np.mean(ratios) == pytest.approx(1.0, abs=3 * np.std(ratios) / np.sqrt(len(ratios)))
    assert max(ratios) < OUT_OF_STEP


@pytest.mark.parametrize("shift", [0.5, -0.69, 2.3])
def test_readings_moved_by_interpolation_keep_below_the_limit(run, shift):
    samples = np.arange(len(run.t))
    moved = replace(run, shifted=shift)
    ratios, sizes = [], []
    for seed in SEEDS:
        noise = np.random.default_rng(seed).normal(0.0, 1e-4, run.position.shape)
        noise = np.column_stack([np.interp(samples + shift, samples, n) for n in noise.T])
        error = prediction_error(run, noise)
        ratios.append(out_of_step([moved], [error], BANDWIDTH))
        sizes.append(np.std(error[50:-50]))
    assert np.mean(ratios) == pytest.approx(1.0, abs=3 * np.std(ratios) / np.sqrt(len(ratios)))
    assert max(ratios) < OUT_OF_STEP
    lsb = 1e-4 * np.sqrt(12.0)
    assert quantisation_floor(lsb, BANDWIDTH, run.dt, shift) == pytest.approx(
        np.mean(sizes), rel=0.01
    )


def test_a_hum_is_seen_and_what_repeats_is_not(run):
    noise = np.random.default_rng(0).normal(0.0, 1e-4, run.position.shape)
    t = run.t[:, None]
    hum = 0.02 * np.sin(2.0 * np.pi * 7.3 * t)
    in_time = 0.02 * np.sin(2.0 * np.pi * t / (run.period * run.dt))
    assert out_of_step([run], [prediction_error(run, noise + hum)], BANDWIDTH) > 2.0
    alone = out_of_step([run], [prediction_error(run, noise)], BANDWIDTH)
    with_repeats = out_of_step([run], [prediction_error(run, noise + in_time)], BANDWIDTH)
    assert with_repeats == pytest.approx(alone, rel=0.02)


def test_without_repeated_cycles_nothing_is_said(run):
    assert out_of_step([replace(run, period=None)], [run.position], BANDWIDTH) is None


def test_quantisation_floor_is_what_white_rounding_does(run):
    lsb = 1e-3
    ramp = lsb * np.random.default_rng(0).uniform(-0.5, 0.5, (200_000, 1))
    measured = np.std(prediction_error(run, ramp))
    assert quantisation_floor(lsb, BANDWIDTH, run.dt) == pytest.approx(measured, rel=0.01)


@pytest.mark.parametrize("verdict", ["no_gap", "explained"])
def test_a_disturbance_out_of_step_takes_the_claim_back(verdict):
    claim = Verdict(verdict=verdict, reason="Small.", accepted=None, rivals=(), removed=None)
    assert in_step(claim, 1.1) is claim
    assert in_step(claim, None) is claim
    taken = in_step(claim, 3.0)
    assert taken.verdict == "unexplained"
    assert "3.0 x the noise of the measurement" in taken.reason


def test_readings_without_steps_have_the_floor_of_their_white_noise(run):
    bare = replace(run, lsb=0.0, period=None)
    noise = 2e-4 * np.random.default_rng(4).standard_normal(run.position.shape)
    residual = prediction_error(run, noise)
    floors, _ = noise_floor([bare], [residual], BANDWIDTH)
    expected = np.sqrt(np.mean(residual**2))
    assert np.sqrt(np.mean(floors[0] ** 2)) == pytest.approx(expected, rel=0.1)
    smooth, _ = noise_floor([bare], [0.0 * residual], BANDWIDTH)
    assert 0.0 < np.max(np.abs(smooth[0])) < 1e-6  # next to nothing, and not zero
