"""Empirical step sizes of the MM3A, and the stepper that plays them."""

import time
from dataclasses import replace

import numpy as np
import pytest
from scipy.integrate import quad

from gapscope.models.mm3a import dynamics, step_size, stepper
from gapscope.models.mm3a.arm import STANDARD_GRAVITY, Arm, gravity_in_base
from gapscope.models.mm3a.step_size import NEGATIVE, POSITIVE, PrismaticStep, RotaryStep, StepModel
from gapscope.models.mm3a.stepper import Conditions

ARM = Arm()
TABLE = StepModel().table()
NO_FORCE = (0.0, 0.0, 0.0)
TRAVEL = ARM.upper_3 - ARM.lower_3


def size(joint, side, q, theta=0.0, psi=0.0, force=NO_FORCE):
    load = step_size.load_factors(q, gravity_in_base(theta, psi), force, ARM)[joint]
    return step_size.step_size(joint, side, q, load, TABLE, TRAVEL)


def test_load_factors_are_the_printed_cosines_at_q1_zero():
    """cos(zeta) cos(theta) of (4.5) and sin(zeta) cos(theta) of (6.10), zeta = psi - q2."""
    rng = np.random.default_rng(0)
    for theta, psi in rng.uniform(-np.pi, np.pi, (50, 2)):
        q = (0.0, rng.uniform(ARM.lower_2, ARM.upper_2), rng.uniform(0, 0.012))
        _, rotary, prismatic = step_size.load_factors(q, gravity_in_base(theta, psi), NO_FORCE, ARM)
        assert rotary == pytest.approx(np.sin(psi - q[1]) * np.cos(theta), abs=1e-14)
        assert prismatic == pytest.approx(np.cos(psi - q[1]) * np.cos(theta), abs=1e-14)


def test_joint_1_swaps_the_roles_of_the_tilts():
    """Section 6.2: gravity loads joint 1 at theta = -pi/2 and not at theta = 0."""
    for q1 in np.linspace(ARM.lower_1, ARM.upper_1, 7):
        q = (q1, -np.pi / 2, 0.005)
        upright = step_size.load_factors(q, gravity_in_base(0.0, 0.0), NO_FORCE, ARM)[0]
        tilted = step_size.load_factors(q, gravity_in_base(-np.pi / 2, 0.0), NO_FORCE, ARM)[0]
        assert upright == pytest.approx(0.0, abs=1e-15)
        assert tilted == pytest.approx(-np.cos(q1), abs=1e-14)


@pytest.mark.parametrize(
    ("side", "q2", "theta", "expected_nm"),
    [
        # Typed in from Fig. 4.13 through (4.5), at the calibration postures of Fig. 6.1.
        (POSITIVE, -np.pi / 2, 0.0, 972.0),
        (POSITIVE, 0.0, -np.pi / 2, 972.0 * 0.73),
        (POSITIVE, 0.0, 0.0, 0.73 * (972.0 - 375.55)),
        (POSITIVE, -np.pi, 0.0, 0.73 * (972.0 + 375.55)),
        (NEGATIVE, -np.pi / 2, 0.0, 899.0),
        (NEGATIVE, 0.0, -np.pi / 2, 899.0 * 0.75),
        (NEGATIVE, 0.0, 0.0, 0.75 * (899.0 + 436.0)),
        (NEGATIVE, -np.pi, 0.0, 0.75 * (899.0 - 436.0)),
    ],
)
def test_prismatic_step_at_the_postures_of_figure_6_1(side, q2, theta, expected_nm):
    assert size(2, side, (0.0, q2, 0.004), theta) * 1e9 == pytest.approx(expected_nm, rel=1e-12)


def test_rotation_about_the_prismatic_axis_does_not_matter():
    """Section 4.4: theta turns the level arm about its own axis."""
    sizes = [size(2, POSITIVE, (0.0, -np.pi / 2, 0.0), theta) for theta in (0.0, -0.7, -1.5)]
    assert np.ptp(sizes) < 1e-20


@pytest.mark.parametrize("q3", [0.0, 0.006, 0.012])
def test_rotary_steps_down_are_larger_than_level_and_up_are_smaller(q3):
    """Section 5.3; at q1 = 0 and q2 = -pi/2 positive motion lifts the arm."""
    q = (0.0, -np.pi / 2, q3)
    for side, sign in ((POSITIVE, -1.0), (NEGATIVE, 1.0)):
        free = size(1, side, q, theta=-np.pi / 2)
        assert sign * (size(1, side, q) - free) > 1e-6


def test_extension_interpolates_linearly_between_the_printed_ends():
    ends = [size(1, NEGATIVE, (0.0, -np.pi / 2, q3)) for q3 in (0.0, 0.012)]
    p = StepModel().joint_2_negative
    assert ends == pytest.approx([p.basic_retracted + 3.83e-6, p.basic_extended + 23.94e-6])
    middle = size(1, NEGATIVE, (0.0, -np.pi / 2, 0.006))
    assert middle == pytest.approx(np.mean(ends), rel=1e-14)


def test_a_weight_on_the_tip_acts_like_a_heavier_link():
    """Chapter 3: a joint cannot tell a force through J^T from gravity."""
    hung = 0.5 * ARM.mass_3
    weight = (0.0, 0.0, -hung * STANDARD_GRAVITY)
    q = (0.0, -0.3, 0.003)
    level = gravity_in_base(0.0, 0.0)
    bare = step_size.load_factors(q, level, NO_FORCE, ARM)
    loaded = step_size.load_factors(q, level, weight, ARM)
    assert loaded[2] == pytest.approx(1.5 * bare[2], rel=1e-13)
    lever = (ARM.forearm + q[2]) * hung / dynamics.moment_2(q, ARM)
    assert loaded[1] == pytest.approx((1.0 + lever) * bare[1], rel=1e-13)


def test_compiled_run_equals_the_law_step_by_step():
    rng = np.random.default_rng(4)
    commands = rng.integers(-1, 2, (400, 3))
    conditions = Conditions(
        theta=0.3,
        psi=-0.2,
        force=(0.001, 0.002, -0.003),
        scale=((0.9, 1.1), (1.05, 0.95), (1.2, 0.8)),
        heating=(0.02, 0.03, 0.04),
        heating_steps=100.0,
        reversal_loss=(0.5, 0.25, 0.1),
    )
    start = (0.2, -1.0, 0.005)
    travel = stepper.run(commands, start, conditions=conditions)
    q, last, taken = np.array(start), np.zeros(3), np.zeros(3)
    for row, reached in zip(commands, travel.positions[1:]):
        for joint in np.flatnonzero(row):
            stepper.coarse_step(
                joint,
                row[joint],
                q,
                last,
                taken,
                TABLE,
                conditions.session(),
                ARM,
                ARM.lower,
                ARM.upper,
            )
        np.testing.assert_allclose(reached, q, rtol=1e-13)
    np.testing.assert_array_equal(travel.taken, np.abs(commands).sum(axis=0))


def test_end_stop_holds_the_joint_and_is_reported():
    commands = np.tile([0, 0, -1], (20, 1))
    travel = stepper.run(commands, (0.0, -np.pi / 2, 5e-6))
    assert travel.positions[-1, 2] == 0.0
    free = int(5e-6 / 899e-9)
    np.testing.assert_array_equal(travel.stopped[:, 2], [False] * free + [True] * (20 - free))


def test_step_count_is_the_integral_of_distance_over_step_size():
    """Across the range of joint 2: N = integral dq/gamma within one step and its O(gamma) remainder."""
    start = (0.0, ARM.upper_2, 0.012)
    counted = stepper.steps_between(1, start, ARM.lower_2)
    exact, _ = quad(lambda q2: 1.0 / size(1, NEGATIVE, (0.0, q2, 0.012)), ARM.lower_2, ARM.upper_2)
    assert counted == pytest.approx(exact, abs=1.5)


def test_direction_memory_takes_from_the_first_step_back_only():
    loss = Conditions(reversal_loss=(0.0, 0.0, 0.4))
    commands = np.array([[0, 0, 1], [0, 0, -1], [0, 0, -1], [0, 0, 1]])
    motion = np.diff(stepper.run(commands, (0, -np.pi / 2, 0.006), conditions=loss).positions[:, 2])
    assert motion * 1e9 == pytest.approx([972.0, -0.6 * 899.0, -899.0, 0.6 * 972.0], rel=1e-9)


def test_warming_saturates_at_its_amplitude():
    warm = Conditions(heating=(0.0, 0.0, 0.05), heating_steps=100.0)
    commands = np.tile([0, 0, 1], (1500, 1))
    motion = np.diff(stepper.run(commands, (0, -np.pi / 2, 0.0), conditions=warm).positions[:, 2])
    assert motion[0] == pytest.approx(972e-9, rel=1e-9)
    assert motion[100] == pytest.approx(972e-9 * (1 + 0.05 * (1 - np.exp(-1.0))), rel=1e-9)
    assert motion[-1] == pytest.approx(972e-9 * 1.05, rel=1e-6)


def test_fine_mode_moves_without_slip_inside_the_stroke():
    assert stepper.fine_extension(0.0, 3, 0) == pytest.approx(3e-7)
    assert stepper.fine_extension(0.0, 10**9, 0) == 2e-4
    assert stepper.fine_extension(0.0, -(10**9), 2) == -0.5e-6


def test_constant_step_model_of_chapter_7_ignores_load_posture_and_extension():
    table = step_size.constant_steps(StepModel()).table()
    for joint in range(3):
        sizes = [
            step_size.step_size(joint, POSITIVE, q, load, table, TRAVEL)
            for q in ((0, 0, 0), (1, -2, 0.012))
            for load in (-1.0, 1.0)
        ]
        assert np.ptp(sizes) == 0.0


def test_a_load_beyond_the_model_is_refused_and_not_looped_forever():
    heavy = Conditions(force=(0.0, 0.0, -1.0))
    with pytest.raises(ValueError, match="joint 3 stops making way"):
        stepper.steps_between(2, (0.0, 0.0, 0.0), 0.012, conditions=heavy)


def test_unusable_input_is_refused():
    with pytest.raises(ValueError, match="elements -1, 0 or 1"):
        stepper.run([[0, 0, 2]], (0, 0, 0))
    with pytest.raises(ValueError, match="outside the limits"):
        stepper.run([[0, 0, 1]], (0, 1.0, 0))
    with pytest.raises(ValueError, match="expected basic > 0"):
        PrismaticStep(basic=-1e-6, recoil=0.2, load=0.0)
    with pytest.raises(ValueError, match="stands still at full load"):
        RotaryStep(
            basic_retracted=1e-5, basic_extended=1e-5, load_retracted=0.0, load_extended=2e-5
        )
    with pytest.raises(ValueError, match="three positive pairs"):
        Conditions(scale=((1.0, 1.0),))
    with pytest.raises(ValueError, match="shares in"):
        replace(Conditions(), reversal_loss=(0.0, 0.0, 1.5))


def test_stepper_plays_a_million_steps_a_second():
    commands = np.zeros((1_000_000, 3), dtype=np.int64)
    commands[:, 1] = 1 - 2 * (np.arange(1_000_000) // 20_000 % 2)
    stepper.run(commands[:10], (0, -1.5, 0.006))
    best = np.inf
    for _ in range(3):
        before = time.process_time()
        stepper.run(commands, (0, -1.5, 0.006))
        best = min(best, time.process_time() - before)
    assert best < 1.0
