"""A position servo settles where its torques balance, and follows the exact solution as steps shrink."""

import numpy as np
import pytest

from gapscope.models import position_servo, position_servo_kernel

DT = 0.02
IDLE = position_servo.ideal_servo(damping=0.05, inertia=0.0, delay=0.0)


def angle(servo, reference, load, substeps=4):
    out = np.zeros_like(reference)
    position_servo_kernel.simulate(reference, load, servo, DT, substeps, 1, out)
    return out


def test_a_load_sags_by_itself_over_the_stiffness():
    assert angle(IDLE, np.zeros(200), np.full(200, 0.03))[-1] == pytest.approx(0.03, rel=1e-12)


def test_dry_friction_holds_the_angle_back_by_its_level():
    there = np.linspace(0.0, 1.0, 500)
    q = angle(
        IDLE._replace(level=0.02, damping=0.0), np.concatenate([there, there[::-1]]), np.zeros(1000)
    )
    assert q[499] == pytest.approx(1.0 - 0.02, abs=1e-12)
    assert q[-1] == pytest.approx(0.02, abs=1e-12)


def test_error_of_a_step_response_is_of_first_order():
    t = DT * np.arange(20)
    exact = 1.0 - np.exp(-t / 0.05)
    errors = [np.max(np.abs(angle(IDLE, np.ones(20), np.zeros(20), n) - exact)) for n in (40, 80)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)
