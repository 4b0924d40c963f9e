"""Where a gap lies: made gaps lie where they were put, and every list of shares is whole."""

import numpy as np
import pytest

from gapscope.analysis.gap.location import locate
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine

WHOLE = (
    "signals", "joints", "task", "regimes", "bands", "harmonics", "directions", "speeds",
    "accelerations", "since_reversal", "positions", "loads", "times", "runs",
)  # fmt: skip


@pytest.fixture(scope="module")
def case(nominal_logset):
    machine, runs = read_machine(load_logset(nominal_logset))
    return machine, [run for run in runs if run.use == "fit"]


def made(case, effort_of):
    """Shares of a gap of this effort; the machine's map from residual to effort is inverted."""
    machine, runs = case
    residuals = [
        effort_of(run) @ np.linalg.inv(machine.unexplained(np.eye(2), run)) for run in runs
    ]
    return locate(runs, residuals, machine, 0)


def share(rows, name):
    return next(row["share"] for row in rows if row["name"] == name)


def test_every_list_of_shares_sums_to_one(case):
    rng = np.random.default_rng(0)
    found = made(case, lambda run: rng.normal(size=run.position.shape))
    for key in WHOLE:
        assert sum(row["share"] for row in found[key]) == pytest.approx(1.0), key


def test_a_gap_of_one_direction_is_found_there(case):
    found = made(case, lambda run: np.where(run.reference_rate > 1.0, 1.0, 0.0))
    assert share(found["directions"], "forward") > 0.99


def test_a_gap_after_reversals_is_found_there(case):
    def burst(run):
        turned = np.diff(np.sign(run.reference_rate), axis=0, prepend=0.0) != 0.0
        return np.where(turned, 1.0, 0.0)

    assert share(made(case, burst)["since_reversal"], "under 10 ms") > 0.99


def test_noise_lies_between_the_harmonics_and_a_repeated_gap_on_them(case):
    rng = np.random.default_rng(1)
    noise = made(case, lambda run: rng.normal(size=run.position.shape))
    assert share(noise["harmonics"], "between them") > 0.9
    repeated = made(case, lambda run: run.reference_rate)
    assert share(repeated["harmonics"], "at harmonics of the cycle") > 0.99


def test_coherence_tells_what_follows_the_reference_from_noise(case):
    follows = made(case, lambda run: run.reference_rate)["bands"]
    top = max(follows, key=lambda band: band["share"])
    assert top["coherence"] > 0.9
    rng = np.random.default_rng(2)
    noise = made(case, lambda run: rng.normal(size=run.position.shape))["bands"]
    assert max(band["coherence"] for band in noise if band["share"] > 0.1) < 0.5
