"""Friction laws: they oppose motion, dissipate, and have the limits their equations state."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gapscope.models import drive, friction, presliding

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


def test_stribeck_peak_may_decay_exponentially():
    for v in (0.3, -0.3):
        peak = friction.dry(v, 1.0, 1.0, 0.5, 1.5, 0.01, 1.0)
        assert abs(peak) == pytest.approx(1.0 + 0.5 * np.exp(-0.2), rel=1e-12)


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


def test_sech_form_is_coulomb_with_viscous_friction_far_out_and_peaks_in_between():
    """Roldan (2.27): c v + F_c at speed; with excess the level near rest is F_c + F_x."""
    assert friction.sech_dry(30.0, 0.02, 0.5, 0.3, 5.0, 100.0) == pytest.approx(0.5 + 0.6)
    assert friction.sech_dry(0.05, 0.0, 0.5, 0.3, 1.0, 1000.0) == pytest.approx(0.8, rel=1e-3)
    assert friction.sech_dry(-0.4, 0.0, 0.5, 0.0, 1.0, 3.0) == pytest.approx(
        -0.5 * friction.smooth_sign(0.4, 1.0 / 3.0)
    )


def test_stribeck_level_falls_from_static_to_coulomb():
    assert friction.stribeck_level(0.0, 0.5, 0.8, 0.1) == pytest.approx(0.8)
    assert friction.stribeck_level(-0.1, 0.5, 0.8, 0.1) == pytest.approx(0.5 + 0.3 / np.e)
    assert friction.stribeck_level(0.2, 0.5, 0.8, 0.1, 1.0) == pytest.approx(0.5 + 0.3 / np.e**2)
    assert friction.stribeck_level(9.0, 0.5, 0.8, 0.1) == pytest.approx(0.5)


@given(applied=st.floats(-3.0, 3.0))
def test_stiction_holds_what_is_applied_up_to_its_limit(applied):
    held = friction.karnopp(0.0, applied, 0.5, 0.8, 0.0)
    assert held == (applied if abs(applied) <= 0.8 else np.sign(applied) * 0.8)
    assert friction.karnopp(-0.02, applied, 0.5, 0.8, 0.01) == -0.5
    assert friction.karnopp(0.005, applied, 0.5, 0.8, 0.01) == held


STIFFNESS, SHARES, LEVEL = np.array([900.0, 300.0, 100.0]), np.array([0.5, 0.3, 0.2]), 2.0


def maxwell_path(displacement, level=LEVEL):
    """Total force of three elements along a path of displacements, a step each."""
    forces, slipping, total = np.zeros(3), [False] * 3, []
    for step in np.diff(displacement, prepend=0.0):
        for i in range(3):
            forces[i], slipping[i] = presliding.maxwell_step(
                step / 1e-3, forces[i], slipping[i], STIFFNESS[i], SHARES[i], level, 1e9, 1e-3
            )
        total.append(forces.sum())
    return np.array(total)


def test_maxwell_slip_starts_as_a_spring_and_ends_at_its_level():
    path = np.linspace(0.0, 0.02, 2001)[1:]
    force = maxwell_path(path)
    elastic = path < 0.9 * np.min(SHARES * LEVEL / STIFFNESS)
    assert force[elastic] == pytest.approx(STIFFNESS.sum() * path[elastic])
    assert force[-1] == pytest.approx(LEVEL)


def test_maxwell_slip_forgets_an_inner_loop():
    """Nonlocal memory (Masing): a small loop closes, and the path goes on as if it had not been."""
    up = np.linspace(0.0, 0.003, 301)[1:]
    inner = np.concatenate([np.linspace(0.003, 0.002, 101)[1:], np.linspace(0.002, 0.003, 101)[1:]])
    on = np.linspace(0.003, 0.006, 301)[1:]
    straight = maxwell_path(np.concatenate([up, on]))
    looped = maxwell_path(np.concatenate([up, inner, on]))
    assert looped[-300:] == pytest.approx(straight[-300:], abs=0.02 * LEVEL)
    loss = np.trapezoid(looped[299:500], np.concatenate([up, inner])[299:])
    assert loss > 0.0  # friction took work out of the loop


def test_maxwell_element_reverses_by_sticking_and_approaches_a_new_level():
    assert presliding.maxwell_step(-1.0, 1.0, True, 10.0, 0.5, LEVEL, 1.0, 0.01) == (0.9, False)
    force, slipping = presliding.maxwell_step(1.0, 1.5, True, 10.0, 0.5, LEVEL, 4.0, 0.5)
    assert slipping
    assert force == pytest.approx(1.0 + 0.5 * np.exp(-1.0))
