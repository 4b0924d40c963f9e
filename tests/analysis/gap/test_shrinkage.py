"""The interval of the share removed holds the truth, the floor's own uncertainty included."""

import numpy as np

from gapscope.analysis.gap.bootstrap import energies
from gapscope.analysis.gap.floor import repeatability
from gapscope.analysis.gap.shrinkage import BLOCKS, _percent

PERIOD, CYCLES, RUNS, TRIALS = 200, 3, 2, 150


def trial(random, gap):
    """A right model: before is a periodic gap and white noise, after and floor are noise alone."""
    noises = [random.standard_normal((PERIOD * CYCLES, 1)) for _ in range(RUNS)]
    phase = 2.0 * np.pi * np.arange(PERIOD * CYCLES) / PERIOD
    before = energies([gap * np.sin(phase)[:, None] + noise for noise in noises], BLOCKS)
    floors = energies([repeatability(noise, PERIOD) for noise in noises], BLOCKS)
    return _percent(before, energies(noises, BLOCKS), floors, 0, 0)


def test_the_interval_covers_a_right_model_and_seldom_lies_above_it():
    for gap in (2.0, 20.0):
        random = np.random.default_rng(7)
        ends = [ends for _, ends in (trial(random, gap) for _ in range(TRIALS)) if ends]
        assert len(ends) == TRIALS
        held = [low <= 100.0 <= high for low, high in ends]
        assert np.mean(held) > 0.9
        assert np.mean([low > 100.0 for low, _ in ends]) < 0.05


def test_no_share_is_given_of_a_gap_within_the_floors_uncertainty():
    percent, ends = trial(np.random.default_rng(7), 0.2)
    assert percent is None
    assert ends is None
