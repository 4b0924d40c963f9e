"""A position servo settles where its torques balance, and follows the exact solution as steps shrink."""

import numpy as np
import pytest
from scipy import signal

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


def test_a_share_of_the_load_is_friction():
    servo, there = IDLE._replace(share=0.25, damping=0.0), np.linspace(0.0, 1.0, 500)
    assert angle(servo, there, np.full(500, -0.04))[-1] == pytest.approx(
        1.0 - 0.04 - 0.01, abs=1e-12
    )


def test_clearance_is_crossed_where_the_servo_turns_back():
    there = np.linspace(0.0, 1.0, 500)
    asked = np.concatenate([there, there[::-1]])
    y = angle(IDLE._replace(gap=0.06, damping=0.0), asked, np.zeros(1000))
    assert (y[499], y[-1]) == pytest.approx((1.0 - 0.03, 0.03), abs=1e-12)


def test_a_ramp_arrives_late_by_delay_and_lag():
    t = DT * np.arange(200)
    for late in ({"delay": 0.07}, {"delay": 0.05, "lag": 0.02}):
        q = angle(IDLE._replace(damping=0.0, **late), t, np.zeros(200), substeps=400)
        assert q[-1] == pytest.approx(t[-1] - 0.07, abs=DT / 400)


def test_speed_and_torque_are_limited():
    """Beyond its largest torque a servo turns as the load less that torque drives it."""
    q = angle(IDLE._replace(speed_limit=0.5), np.ones(51), np.zeros(51))
    assert q[-1] == pytest.approx(0.5, rel=1e-12)
    q = angle(IDLE._replace(error_limit=0.02), np.zeros(200), np.full(200, 0.03))
    assert (q[-1] - q[-2]) / DT == pytest.approx((0.03 - 0.02) / 0.05, rel=1e-9)


def test_an_encoder_shows_its_scale_and_zero():
    q = angle(IDLE._replace(scale_error=0.1, zero=-0.2), np.ones(200), np.zeros(200))
    assert q[0] == 0.0
    assert q[-1] == pytest.approx(1.1 - 0.2, rel=1e-9)


@pytest.mark.parametrize("inertia", [0.0, 4e-4])
def test_error_of_a_step_response_is_of_first_order(inertia):
    t, servo = DT * np.arange(20), IDLE._replace(inertia=inertia)
    exact = signal.step(([1.0], [inertia, 0.05, 1.0]), T=t)[1]
    errors = [np.max(np.abs(angle(servo, np.ones(20), np.zeros(20), n) - exact)) for n in (40, 80)]
    assert errors[0] / errors[1] == pytest.approx(2.0, rel=0.05)
