from dataclasses import replace

import numpy as np
import pytest
import yaml
from scipy.stats import norm

from gapscope.analysis.errors import InputError
from gapscope.analysis.examples import next_experiment
from gapscope.analysis.gap.design import Limits, design_experiment, limits_of, top_two
from gapscope.analysis.gap.design.experiment import runs_needed
from gapscope.analysis.gap.design.motions import Motions, scaled
from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.machines.c_drive import c_drive_machine
from gapscope.analysis.simulation import simulate_c_drive, write_c_drive_run
from gapscope.diagrams.c_drive_config import CDriveLoopConfig
from gapscope.models.c_drive import CDriveParameters
from gapscope.models.fourier_motion import load_motion

MACHINE = c_drive_machine(CDriveParameters(), 0.03)
LIMITS = Limits(
    lower=np.array([-0.15, -3.0]),
    upper=np.array([0.0, 3.0]),
    speed=100.0,
    effort=3.0,
    source="test",
)


@pytest.fixture(scope="module")
def diagnosis(tmp_path_factory):
    """A drive with dry friction at its motors, one slow run: explained or ambiguous."""
    folder = tmp_path_factory.mktemp("logs")
    config = CDriveLoopConfig(motion="helical", rate=1.0, cycles=3)
    config.machine.delta = 0.15
    write_c_drive_run(simulate_c_drive(config), folder)
    document = yaml.safe_load((folder / "logset.yaml").read_text())
    document["system"]["nominal"]["delta_N_m"] = 0.0
    (folder / "logset.yaml").write_text(yaml.safe_dump(document))
    return diagnose(folder)


@pytest.fixture(scope="module")
def designed(diagnosis, tmp_path_factory):
    design = design_experiment(diagnosis, candidates=60, seed=1)
    folder = tmp_path_factory.mktemp("design")
    design.save(folder)
    return design, folder


def test_candidates_keep_travel_and_speed_and_use_one_side_only():
    motions = Motions(MACHINE, LIMITS, 1.0)
    rng = np.random.default_rng(0)
    for _ in range(50):
        motion = motions.motion(rng.uniform(-1.0, 1.0, motions.size), 1)
        position, rate, _ = motion.sample(np.linspace(0.0, 1.0, 2000))
        task = position @ MACHINE.task_map.T
        slack = 1e-6  # of rounding
        assert np.all(task >= LIMITS.lower - slack)
        assert np.all(task <= LIMITS.upper + slack)
        assert np.max(np.abs(rate)) <= LIMITS.speed


def test_runs_needed_are_those_of_a_gaussian_log_likelihood_ratio():
    n = runs_needed(1.5, 0.01)
    assert norm.cdf(-np.sqrt(n * 1.5 / 2.0)) <= 0.01 < norm.cdf(-np.sqrt((n - 1) * 1.5 / 2.0))


def test_a_design_tells_more_than_repeating_and_keeps_the_effort(designed, diagnosis):
    design, folder = designed
    bounds = limits_of(diagnosis)
    assert {p.name for p in folder.iterdir()} == {"design.json", "motion.yaml", "design.png"}
    assert design.nats > design.repeat["nats"] > 0.0
    assert max(r.effort for r in design.responses) <= bounds.effort
    assert design.to_json()["expected_nats"]["designed_motion"] == design.nats


def test_simulate_takes_the_motion_and_the_result_can_be_diagnosed(designed, tmp_path):
    _, folder = designed
    config = CDriveLoopConfig(motion=str(folder / "motion.yaml"))
    run = simulate_c_drive(config)
    motion = load_motion(folder / "motion.yaml")
    samples = round(config.cycles * motion.period / config.sample_time)
    reference = motion.sample(config.sample_time * np.arange(samples))[0]
    np.testing.assert_allclose(run.reference, reference, atol=1e-9)
    write_c_drive_run(run, tmp_path / "run")
    found = diagnose(tmp_path / "run")
    assert found.runs[0].period == round(motion.period / config.sample_time)


@pytest.mark.parametrize(("factor", "word"), [(10.0, "limits"), (-1.0, "limits.lowest")])
def test_simulate_refuses_a_motion_outside_the_limits(designed, tmp_path, factor, word):
    design, _ = designed
    scaled(design.motion, factor).save(tmp_path / "m.yaml")
    with pytest.raises(InputError, match=word):
        simulate_c_drive(CDriveLoopConfig(motion=str(tmp_path / "m.yaml")))


def test_simulate_refuses_a_motion_that_needs_too_much_torque(designed):
    _, folder = designed
    config = CDriveLoopConfig(motion=str(folder / "motion.yaml"))
    config.limits.torque = 0.01
    with pytest.raises(InputError, match=r"limits\.torque"):
        simulate_c_drive(config)


def test_no_gap_and_a_single_hypothesis_leave_nothing_to_separate(diagnosis):
    none = replace(diagnosis, verdict=replace(diagnosis.verdict, verdict="no_gap"))
    with pytest.raises(InputError, match="nothing to separate"):
        top_two(none)
    best = [r for r in diagnosis.ranking if r.fit.hypothesis.forms][:1]
    single = replace(
        diagnosis,
        ranking=tuple(best),
        verdict=replace(diagnosis.verdict, accepted=best[0], rivals=()),
    )
    with pytest.raises(InputError, match="no two hypotheses"):
        top_two(single)


@pytest.mark.parametrize(
    ("options", "word"),
    [
        ({"speed": -1.0}, "speed"),
        ({"ranges": {"height": (0.0, 1.0)}}, "height"),
        ({"ranges": {"translation": (1.0, 2.0)}}, "translation"),
    ],
)
def test_impossible_limits_are_named(diagnosis, options, word):
    with pytest.raises(InputError, match=word):
        limits_of(diagnosis, **options)


def test_an_unknown_controller_is_named(diagnosis):
    with pytest.raises(InputError, match="controller"):
        design_experiment(diagnosis, controller="lqr")


# Fits of a diagnosis pass through plants that diverge, whose residuals overflow scipy's norms.
@pytest.mark.filterwarnings("ignore::RuntimeWarning:numpy", "ignore::RuntimeWarning:scipy")
def test_running_the_designed_motion_resolves_an_ambiguous_pair(tmp_path):
    """On the independent machine, whose torque loop lags by 1 ms; the instrument is not told.

    Each motion is enough as far as noise goes; the verdict asks for a margin beyond, and so for two.
    """
    found, designs = next_experiment.main(tmp_path)
    pairs = [(d.pair.first.fit.hypothesis.ids, d.pair.second.fit.hypothesis.ids) for d in designs]
    assert set(pairs[0]) == {("actuator.delay",), ("actuator.lag",)}  # near twins
    assert [d.runs for d in designs] == [1] * len(designs)
    assert [f.verdict.verdict for f in found] == ["ambiguous"] * len(designs) + ["explained"]
    assert [e["id"] for e in found[-1].to_json()["effects"]] == ["actuator.lag"]
    assert (tmp_path / "design1" / "design.png").stat().st_size > 10_000
