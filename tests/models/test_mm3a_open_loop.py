"""Open-loop conversion of tip commands to steps."""

import numpy as np
import pytest

from gapscope.models.mm3a import kinematics, open_loop, step_size, stepper
from gapscope.models.mm3a.arm import Arm
from gapscope.models.mm3a.step_size import StepModel
from gapscope.models.mm3a.stepper import Conditions

ARM, MODEL = Arm(), StepModel()
START = (0.3, -1.2, 0.006)
# Half a step of each joint at the tip: levers 50 mm, 44 mm, largest steps of Figs. 4.13 and 5.6.
HALF_STEP_AT_TIP = 0.5 * (0.050 * 122e-6 + 0.044 * 122e-6 + 1.35e-6)


def test_joint_rates_invert_the_jacobian():
    rng = np.random.default_rng(0)
    for _ in range(100):
        q, velocity = rng.uniform(ARM.lower, ARM.upper), rng.normal(size=3)
        rates = np.array(open_loop.joint_rates(velocity, q, ARM))
        J = np.array(kinematics.jacobian(q, ARM))
        scale = np.abs(J) @ np.abs(rates)
        np.testing.assert_allclose(J @ rates, velocity, rtol=0, atol=1e-13 * scale.max())


def test_re_planning_with_the_true_model_stays_within_half_a_step_of_the_path():
    goal = np.add(kinematics.tip(START, ARM), [0.002, -0.001, 0.003])
    path = open_loop.straight_path(kinematics.tip(START, ARM), goal, 5e-5)
    commands, believed = open_loop.follow(path, START)
    travel = stepper.run(commands, START)
    np.testing.assert_allclose(travel.positions, believed, rtol=1e-13)
    tips = np.array([kinematics.tip(q, ARM) for q in travel.positions[1:]])
    assert np.linalg.norm(tips - path, axis=1).max() < HALF_STEP_AT_TIP


def test_a_joint_steps_as_soon_as_it_is_half_a_step_behind():
    """On a path so slow that it moves by 2 % of a step per tick."""
    tip = np.array(kinematics.tip(START, ARM))
    path = open_loop.straight_path(tip, tip + 40e-6 * np.array([0.6, 0.48, 0.64]), 2e-6)
    _, believed = open_loop.follow(path, START)
    wanted = np.array([kinematics.inverse(point, ARM) for point in path])
    errors = np.abs(believed[1:] - wanted).max(axis=0)
    sizes = [np.abs(np.diff(believed[:, joint])).max() for joint in range(3)]
    np.testing.assert_allclose(errors / sizes, 0.5, atol=0.05)


def test_differential_conversion_is_exact_for_small_moves_and_errs_with_distance():
    """Second order in the move: steps and Jacobian are taken at the start only."""
    errors = []
    for length in (0.5e-3, 1e-3, 2e-3):
        move = length * np.array([0.6, -0.3, 0.7416])
        commands = open_loop.interleave(open_loop.differential_steps(move, START))
        end = stepper.run(commands, START).positions[-1]
        reached = np.subtract(kinematics.tip(end, ARM), kinematics.tip(START, ARM))
        errors.append(np.linalg.norm(reached - move))
    ratios = np.divide(errors[1:], errors[:-1])
    np.testing.assert_allclose(ratios, 4.0, rtol=0.35)


def test_wrong_step_sizes_err_in_proportion_to_the_distance():
    """A true step 10 % longer than believed overshoots by 10 % of the way, whatever the length."""
    truth = Conditions(scale=((1.1, 1.1),) * 3)
    for length in (1e-3, 3e-3):
        start_tip = np.array(kinematics.tip(START, ARM))
        path = open_loop.straight_path(start_tip, np.add(start_tip, (0, 0, length)), 5e-5)
        commands, _ = open_loop.follow(path, START)
        end = kinematics.tip(stepper.run(commands, START, conditions=truth).positions[-1], ARM)
        assert np.linalg.norm(end - path[-1]) == pytest.approx(0.1 * length, rel=0.15)


def test_interleaving_keeps_every_step_and_spreads_it():
    commands = open_loop.interleave([7, -3, 0])
    np.testing.assert_array_equal(commands.sum(axis=0), [7, -3, 0])
    assert np.abs(commands).max() == 1
    assert np.flatnonzero(commands[:, 1]).tolist() == sorted(set(np.flatnonzero(commands[:, 1])))
    assert open_loop.interleave([0, 0, 0]).shape == (0, 3)


def test_a_path_outside_the_workspace_is_refused():
    with pytest.raises(ValueError, match="point 1 at"):
        open_loop.follow(np.array([kinematics.tip(START, ARM), (0.2, 0.0, 0.0)]), START)
    with pytest.raises(ValueError, match="speed is 0"):
        open_loop.straight_path((0, 0, 0), (1, 0, 0), 0.0)


def test_no_step_where_the_model_has_none():
    """A joint whose load exceeds the model is left alone rather than driven the wrong way."""
    session = Conditions(force=(0.0, 0.0, -1.0)).session()
    none, zero = np.zeros(3), np.zeros(3)
    step = open_loop.next_step(
        1e-3, 2, (0.0, 0.0, 0.0), none, zero, MODEL.table(), session, ARM.constants()
    )
    assert step == 0
    assert step_size.NEGATIVE == 0
