"""Friction laws: they oppose motion, dissipate, and have the limits their equations state."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gapscope.models import drive, friction

speeds = st.floats(-100.0, 100.0)
levels = st.floats(0.0, 10.0)


@given(v=speeds, forward=levels, backward=levels, breakaway=levels)
def test_dry_friction_never_drives(v, forward, backward, breakaway):
    assert v * friction.dry(v, forward, backward, breakaway, 1.0, 0.1) >= 0.0


@given(v=speeds, coefficient=levels)
def test_viscous_friction_never_drives_while_the_skew_is_smaller(v, coefficient):
    assert v * friction.viscous(v, coefficient, 0.9 * coefficient) >= 0.0


def test_dry_friction_has_its_levels_far_from_zero_speed():
    assert friction.dry(50.0, 1.2, 0.7, 0.4, 1.0, 0.1) == pytest.approx(1.2, rel=1e-12)
    assert friction.dry(-50.0, 1.2, 0.7, 0.4, 1.0, 0.1) == pytest.approx(-0.7, rel=1e-12)


def test_stribeck_peak_is_above_the_sliding_level():
    peak = friction.dry(0.3, 1.0, 1.0, 0.5, 1.0, 0.01)
    assert peak == pytest.approx(1.0 + 0.5 * np.exp(-0.09), rel=1e-12)


@pytest.mark.parametrize("v", [0.7, -0.7])
def test_bristles_settle_at_the_level_and_step_exactly(v):
    stiffness, level = 100.0, 0.3
    z = 0.0
    for _ in range(50):
        z = friction.bristle_step(v, z, stiffness, level, 0.01)
    assert stiffness * z == pytest.approx(np.sign(v) * level, rel=1e-6)
    # One long step and many short ones end at the same place: the step is exact at constant speed.
    once = friction.bristle_step(v, 1e-3, stiffness, level, 0.004)
    many = 1e-3
    for _ in range(1000):
        many = friction.bristle_step(v, many, stiffness, level, 4e-6)
    assert once == pytest.approx(many, rel=1e-11)


def test_bristle_rate_is_the_derivative_of_the_step():
    v, z, stiffness, level, dt = 0.4, 5e-4, 200.0, 0.3, 1e-7
    slope = (friction.bristle_step(v, z, stiffness, level, dt) - z) / dt
    assert slope == pytest.approx(friction.bristle_rate(v, z, stiffness, level), rel=1e-4)


def test_bristles_of_a_drive_hold_the_stribeck_level_at_low_speed():
    """Steady sliding of LuGre: the force is g(v), the sliding level and what is left of the peak."""
    plant = drive.ideal_drive(np.eye(1), np.ones((1, 1)), [0.0], 1e-3)
    plant.element[0, [drive.FORWARD, drive.BACKWARD]] = 0.3
    plant.element[0, drive.BREAKAWAY] = 0.2
    plant.element[0, drive.STRIBECK_SPEED] = 2.0
    plant.element[0, drive.STIFFNESS] = 1e3
    for speed in (0.1, 1.0, -3.0):
        z, out = np.zeros(1), np.zeros(1)
        for _ in range(4000):
            drive.held_friction(np.array([speed]), z, 1e-3, plant, out)
        level = 0.3 + 0.2 * np.exp(-((speed / 2.0) ** 2))
        assert out[0] == pytest.approx(np.sign(speed) * level, rel=1e-9)
