"""Calibration of the step model: the routine of chapter 6, maximum likelihood, ANOVA, the table."""

from dataclasses import astuple, replace

import numpy as np
import pytest
from scipy import stats

from gapscope.analysis.errors import InputError
from gapscope.analysis.mm3a import anova, experiments, likelihood, routine, runs
from gapscope.analysis.mm3a.experiments import Environment
from gapscope.models.mm3a import stepper
from gapscope.models.mm3a.arm import Arm
from gapscope.models.mm3a.step_size import StepModel
from gapscope.models.mm3a.stepper import Conditions

ARM, MODEL = Arm(), StepModel()
TRUTH = experiments.empirical_truth(MODEL, ARM)
QUIET = Environment(day=0.0, run=0.0)
GROUPS = [(joint, direction) for joint in (1, 2, 3) for direction in (-1, 1)]


def true_step(joint, direction):
    return getattr(MODEL, f"joint_{joint}_{'positive' if direction > 0 else 'negative'}")


def perform(plan, **options):
    return experiments.perform(plan, TRUTH, **options)


def test_counted_runs_are_those_of_the_stepper():
    """Quadrature along the run against playing every step, and the count of the limit switch."""
    for run in perform(experiments.calibration_plan(), repeats=1, environment=QUIET):
        conditions = Conditions(theta=run.theta, psi=run.psi)
        played = stepper.steps_between(
            run.joint - 1, (run.q1, run.q2, run.q3), run.target, conditions=conditions
        )
        assert -3 <= run.steps - played <= 7  # one recording, and 1.5 steps of quadrature


def test_prismatic_routine_inverts_the_model_exactly():
    """(6.2)-(6.4) on exact means return the printed parameters of Fig. 4.13."""
    step = routine.prismatic_by_routine(972e-9, 972e-9 * 0.73, 0.73 * (972e-9 - 375.55e-9))
    assert astuple(step) == pytest.approx((972e-9, 0.27, 375.55e-9), rel=1e-12)


@pytest.mark.parametrize("load", [3.83e-6, -8.15e-6, 23.94e-6, -19.40e-6])
def test_iterated_algorithm_returns_the_printed_loads(load):
    """From the exact mean of Fig. 5.6's d; the step-by-step simulation is good to O(step) of it."""
    loaded = routine.mean_loaded_step(92e-6, load)
    assert routine.load_exactly(92e-6, loaded) == pytest.approx(load, rel=1e-9)
    result = routine.load_by_iteration(92e-6, loaded)
    assert result.load == pytest.approx(load, rel=1e-3)


def test_iteration_converges_linearly_and_meets_the_printed_error_for_small_loads_only():
    """Section 6.2 claims 1e-11 rad after five iterations; the error falls about sixfold each time."""
    small = routine.load_by_iteration(92e-6, 92e-6 + 1e-6)
    assert abs(small.errors[-1]) < 1e-11
    large = routine.load_by_iteration(92e-6, 92e-6 + 9.2e-6)
    assert 1e-9 < abs(large.errors[-1]) < 1e-8
    ratios = large.errors[1:] / large.errors[:-1]
    np.testing.assert_allclose(ratios, ratios.mean(), rtol=0.2)
    exact = routine.load_exactly(92e-6, 92e-6 + 9.2e-6)
    assert large.load == pytest.approx(exact, rel=1e-4)  # harmless beside the scatter of runs


def test_iteration_that_leaves_the_model_is_refused_and_not_looped_forever():
    loaded = routine.mean_loaded_step(92e-6, -85e-6)
    with pytest.raises(ValueError, match="stands still"):
        routine.load_by_iteration(92e-6, loaded)
    assert routine.load_exactly(92e-6, loaded) == pytest.approx(-85e-6, rel=1e-6)


def test_quadratic_of_equation_6_6_holds_in_hundredths_of_a_radian():
    refit, largest = routine.refit_quadratic()
    assert routine.PRINTED[0] == pytest.approx(refit[0], rel=0.10)
    assert routine.PRINTED[1] == pytest.approx(refit[1], rel=0.03)
    assert abs(refit[2]) < 0.05e-6  # the printed 0.642 urad is a bias at zero load
    assert largest < 2e-6
    as_printed = 3.41 * 9.2e-6**2 + 0.025 * 9.2e-6 + 6.42e-7
    exact = routine.load_exactly(92e-6, 92e-6 + 9.2e-6)
    assert as_printed < 0.05 * exact  # read in rad, the printed equation is off thirtyfold
    in_hundredths = 3.41 * (100 * 9.2e-6) ** 2 + 0.025 * (100 * 9.2e-6) + 6.42e-7
    assert in_hundredths == pytest.approx(exact, rel=0.05)
    assert routine.load_by_quadratic(92e-6, 92e-6 + 9.2e-6) == pytest.approx(in_hundredths)


def test_load_dependence_of_the_mean_is_that_of_the_range():
    """First order: the mean of sin over [-pi/6, 7 pi/6] is sqrt(3)/(4 pi/3) = 0.4135."""
    slope = (routine.mean_loaded_step(92e-6, 1e-9) - 92e-6) / 1e-9
    assert slope == pytest.approx(np.sqrt(3) / (4 * np.pi / 3), rel=1e-4)


@pytest.mark.parametrize(("joint", "direction"), GROUPS)
def test_routine_recovers_the_truth_from_noiseless_counts(joint, direction):
    """Within the recording of five steps in some 10^4, which the differences amplify."""
    counted = perform(experiments.calibration_plan(), repeats=1, environment=QUIET)
    found = routine.calibrate_by_routine(counted, joint, direction)
    expected = np.array(astuple(true_step(joint, direction)))
    resolution = 0.002 * np.array(astuple(found)).max() if joint != 3 else 1e-3
    np.testing.assert_allclose(astuple(found), expected, rtol=5e-3, atol=resolution * 1e-1)


@pytest.mark.parametrize(("joint", "direction"), GROUPS)
def test_likelihood_recovers_the_truth_from_noiseless_counts(joint, direction):
    plan = experiments.calibration_plan()
    counted = perform(plan, repeats=2, environment=QUIET)
    found = likelihood.estimate(counted, joint, direction)
    expected = np.array(astuple(true_step(joint, direction)))
    # 2.5 steps of rounding in 10 000 to 50 000, relative to the basic step.
    unit = [1.0 if name == "recoil" else expected[0] for name in found.names]
    np.testing.assert_allclose(found.values / unit, expected / unit, rtol=0.0, atol=8e-4)
    assert astuple(found.step()) == pytest.approx(found.values)


def replicates(plan, joint, direction, count):
    chosen = [run for run in plan if (run.joint, run.direction) == (joint, direction)]
    scatter = Environment(day=0.0, run=0.003)
    return [perform(chosen, environment=scatter, seed=seed) for seed in range(count)]


@pytest.mark.parametrize(("joint", "direction"), [(2, 1), (3, -1)])
def test_intervals_cover_the_truth_at_their_level(joint, direction):
    """120 replicates, seeds 0-119: coverage of 95 % +- 3 binomial deviations per parameter."""
    count = 120
    truth = np.array(astuple(true_step(joint, direction)))
    inside = np.zeros(truth.size)
    for data in replicates(experiments.calibration_plan(), joint, direction, count):
        found = likelihood.estimate(data, joint, direction)
        inside += np.abs(found.values - truth) <= found.half_widths
    low, high = stats.binom.ppf([0.001, 0.999], count, 0.95)
    assert np.all((inside >= low) & (inside <= high)), inside


def test_likelihood_beats_the_routine_when_it_may_use_more_runs():
    """Root mean square error of d at 12 mm over 30 replicates (seeds 0-29) with interval runs."""
    plan = experiments.rotary_plan(2) + experiments.interval_plan(0.012)
    truth = true_step(2, 1).load_extended
    errors = {"routine": [], "likelihood": []}
    for data in replicates(plan, 2, 1, 30):
        by_routine = routine.calibrate_by_routine(data, 2, 1, method="exact")
        by_likelihood = likelihood.estimate(data, 2, 1)
        errors["routine"].append(by_routine.load_extended - truth)
        errors["likelihood"].append(by_likelihood.values[3] - truth)
    rms = {name: np.sqrt(np.mean(np.square(values))) for name, values in errors.items()}
    assert rms["likelihood"] < 0.6 * rms["routine"]


def test_day_factor_is_estimated_with_its_interval():
    data = perform(experiments.prismatic_plan(), days=2, environment=Environment(day=0.03))
    found = likelihood.estimate(data, 3, 1)
    factor, width = found.days["day-2"]
    first, second = (
        np.mean([r.mean_step for r in data if r.day == day and r.direction == 1])
        for day in ("day-1", "day-2")
    )
    assert factor == pytest.approx(second / first, abs=width)
    assert 0.0 < width < 0.01


def test_undetermined_parameters_are_named():
    retracted = [r for r in experiments.rotary_plan(2) if r.q3 == 0.0]
    data = perform(retracted, repeats=3)
    with pytest.raises(InputError, match="basic_extended"):
        likelihood.estimate(data, 2, 1)
    with pytest.raises(InputError, match="at least as many runs"):
        likelihood.estimate(data[:2], 2, 1)


def test_routine_names_the_missing_configuration():
    data = [
        r for r in perform(experiments.calibration_plan()) if not (r.joint == 3 and r.q2 == 0.0)
    ]
    with pytest.raises(InputError, match="none covers the full range at q2 = 0"):
        routine.calibrate_by_routine(data, 3, 1)


def test_anova_finds_day_and_direction_but_not_rotation():
    """The verdicts of sections 4.2, 4.4 and 5.2 for planted effects, seed 3."""
    plan = experiments.rotation_plan() + experiments.rotary_plan(2)
    data = perform(plan, days=2, environment=Environment(day=0.02, run=0.002), seed=3)
    found = anova.effects(data)
    by_factor = {
        (factor, joint): [e.significant for e in found if e.factor == factor and e.joint == joint]
        for factor, joint in (("day", 3), ("direction", 3), ("direction", 2), ("rotation", 3))
    }
    assert all(by_factor["direction", 3])
    assert all(by_factor["direction", 2])
    assert np.mean(by_factor["day", 3]) > 0.5
    assert not any(by_factor["rotation", 3])


def test_anova_keeps_its_level_without_an_effect():
    """120 data sets without day effect, seeds 0-119: 5 % false alarms within 3 deviations."""
    plan = experiments.prismatic_plan()[:1]
    exact = Environment(day=0.0, run=0.003)
    alarms = sum(
        anova.effects(experiments.perform(plan, TRUTH, days=2, environment=exact, seed=seed))[
            0
        ].significant
        for seed in range(120)
    )
    assert alarms <= stats.binom.ppf(0.999, 120, 0.05)


def test_physical_truth_is_calibrated_like_any_other():
    """The physical actuator under the empirical model: loads of the right sign, misfit visible."""
    truth = experiments.physical_truth(ARM)
    plan = experiments.prismatic_plan() + experiments.posture_plan()
    data = experiments.perform(plan, truth, repeats=2, environment=QUIET)
    out, into = (likelihood.estimate(data, 3, direction) for direction in (1, -1))
    assert out.values[2] > 0.0 > into.values[2]  # c_+ > 0 > c_-, as in Fig. 4.13
    assert abs(out.values[1]) < 0.05  # no recoil in a rigid frame: b is not explained
    assert out.scatter > 0.02  # a straight line through a curved load trend


def test_table_survives_writing_and_reading(tmp_path):
    data = perform(experiments.calibration_plan(), days=2)
    runs.write_runs(tmp_path / "steps.csv", data)
    assert runs.read_runs(tmp_path / "steps.csv") == data


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("3,-1", "4,-1"), "joint 4"),
        (("day-1", "day-1,9"), "steps.csv, line"),
        (("steps", "count"), "columns steps are missing"),
    ],
)
def test_unusable_tables_are_refused(tmp_path, change, message):
    path = tmp_path / "steps.csv"
    runs.write_runs(path, perform(experiments.prismatic_plan(), repeats=1))
    path.write_text(path.read_text().replace(*change))
    with pytest.raises(InputError, match=message):
        runs.read_runs(path)


def test_runs_outside_the_machine_are_refused(tmp_path):
    path = tmp_path / "steps.csv"
    run = perform(experiments.prismatic_plan(), repeats=1)[0]
    runs.write_runs(path, [replace(run, target=0.5)])
    with pytest.raises(InputError, match=r"line 2.*leaves the joint limits"):
        runs.read_runs(path)
    with pytest.raises(InputError, match="no such file"):
        runs.read_runs(tmp_path / "none.csv")
    with pytest.raises(ValueError, match="expected the target on that side"):
        replace(run, direction=-run.direction)
