"""The servo pendulum conserves, dissipates, holds and turns as its equations say."""

import numpy as np
import pytest

from gapscope.models import servo_pendulum, servo_pendulum_kernels

KT, R, J, MGL = 0.35, 3.4, 6.6e-3, 0.48
IDEAL = servo_pendulum.ideal_servo(J, MGL, KT, R)
H = 1e-3


def motion(servo, q, v=0.0, voltage=0.0, connected=1.0, steps=2000, h=H):
    states = [(q, v)]
    for _ in range(steps):
        states.append(servo_pendulum.step(*states[-1], voltage, connected, h, servo))
    return np.array(states).T


def energy(q, v):
    return 0.5 * J * v**2 + MGL * (1.0 - np.cos(q))


def test_the_free_pendulum_keeps_its_energy():
    q, v = motion(IDEAL, 1.0, connected=0.0)
    # Half drift, kick, half drift conserves up to (omega h)^2 / 8, with omega^2 = m g l / J.
    assert np.ptp(energy(q, v)) < energy(1.0, 0.0) * (MGL / J) * H**2


def test_second_order_in_the_step():
    ends = [motion(IDEAL, 1.0, connected=0.0, steps=n, h=2.0 / n)[0, -1] for n in (500, 1000, 2000)]
    assert (ends[0] - ends[1]) / (ends[1] - ends[2]) == pytest.approx(4.0, rel=0.02)


def test_the_back_emf_takes_what_the_motor_turns_into_heat():
    q, v = motion(IDEAL, 1.0)
    loss = np.sum(KT**2 / R * (0.5 * (v[1:] + v[:-1])) ** 2) * H
    assert energy(q[0], v[0]) - energy(q[-1], v[-1]) == pytest.approx(loss, rel=1e-3)


def test_without_load_it_turns_as_fast_as_its_back_emf_allows():
    free = IDEAL._replace(gravity=0.0)
    decay = np.exp(-2.0 * KT**2 / (R * J))  # what is left to gain after two seconds
    rate = motion(free, 0.0, voltage=2.0)[1, -1]
    assert rate == pytest.approx(2.0 / KT * (1.0 - decay), rel=1e-6)


def test_dry_friction_takes_the_same_swing_from_every_half_period():
    level = 4e-3
    servo = IDEAL._replace(forward=level, backward=level)
    q, _ = motion(servo, 0.3, connected=0.0)
    turns = np.abs(q[1:-1][np.diff(np.sign(np.diff(q))) != 0])
    fall = MGL * -np.diff(np.cos(np.concatenate([[0.3], turns])))
    swept = np.concatenate([[0.3], turns[:-1]]) + turns
    # Energy of each half swing: what the friction has taken, up to the sampled turning points.
    np.testing.assert_allclose(fall[:3], -level * swept[:3], rtol=0.01)


@pytest.mark.parametrize(("share", "held"), [(0.99, True), (1.01, False)])
def test_a_stuck_load_holds_up_to_the_budget_exactly(share, held):
    servo = IDEAL._replace(motor_share=0.2, load_share=0.2, forward=0.02, backward=0.02)
    q = 0.5
    load = MGL * np.sin(q)
    # Driving up: tau_m - load = F = level + s (tau_m + load).
    motor = (load + 0.02 + 0.2 * load) / 0.8
    end = motion(servo, q, voltage=load * R / KT + share * (motor - load) * R / KT, steps=50)
    assert bool(np.ptp(end[0]) == 0.0) is held


def test_friction_at_rest_is_larger_where_it_decays_with_speed():
    servo = IDEAL._replace(motor_share=0.1, load_share=0.1, rest_share=2.0, stribeck_speed=0.5)
    budget = [servo_pendulum.friction_budget(v, 0.3, -0.2, servo) for v in (1e-6, 0.5, 50.0)]
    expected = [0.05 * 3.0, 0.05 * (1.0 + 2.0 * np.exp(-1.0)), 0.05]
    np.testing.assert_allclose(budget, expected, rtol=1e-9)


def test_the_firmware_asks_for_its_register_of_counts():
    # 100 counts of error at gain 400 write 100 * 400 / 256 of 885.
    error = 100 * 2.0 * np.pi / 4096
    assert servo_pendulum.duty(error, 400.0) == pytest.approx(156.25 / 885)
    assert servo_pendulum.duty(-10.0, 400.0) == -1.0


def test_a_limit_and_a_droop_of_the_current_bound_the_torque():
    limited, drooping = IDEAL._replace(limit=1.0), IDEAL._replace(droop=0.1)
    assert servo_pendulum.motor_torque(7.0, 0.0, limited) == pytest.approx(KT)
    current = 7.0 / R
    torque = servo_pendulum.motor_torque(-7.0, 0.0, drooping)
    assert torque == pytest.approx(-KT * current * (1.0 - 0.1 * current))


def run(servo, gain=400.0, dt=0.005, substeps=5):
    t = np.arange(0.0, 4.0, dt)
    reference = 0.8 * np.sin(2.0 * t) * np.sin(5.0 * t)
    position, voltage = np.zeros_like(t), np.zeros_like(t)
    servo_pendulum_kernels.simulate(
        t, reference, 7.4, gain, np.ones_like(t), servo, substeps, position, voltage
    )
    return t, reference, position, voltage


def prediction_error(servo, t, position, voltage, early=0, gain=400.0, bandwidth=20.0):
    """Prediction errors with a log whose voltage comes ``early`` samples early."""
    residual = np.empty_like(t)
    # Between samples the firmware holds its reference: duty(ref - q) changes with q alone.
    slope = servo_pendulum.duty(1e-3, gain) / 1e-3
    arriving = voltage - 7.4 * slope * np.append(np.diff(position), 0.0)
    voltage, arriving = (np.append(v[early:], np.zeros(early)) for v in (voltage, arriving))
    servo_pendulum_kernels.predict(
        t, position, voltage, arriving, np.ones_like(t), servo, 3, bandwidth, residual
    )
    return residual


def test_the_model_that_made_a_log_predicts_it_to_the_encoder():
    servo = IDEAL._replace(motor_share=0.2, load_share=0.2, viscous=0.005)
    t, _, position, voltage = run(servo)
    right = np.sqrt(np.mean(prediction_error(servo, t, position, voltage) ** 2))
    wrong = np.sqrt(np.mean(prediction_error(IDEAL, t, position, voltage) ** 2))
    assert right < 2.0 * np.pi / 4096  # one count
    assert wrong > 10.0 * right


def test_late_voltage_is_predicted_late():
    t, _, position, voltage = run(IDEAL)
    late = prediction_error(IDEAL._replace(delay=0.03), t, position, voltage, early=6)
    early = prediction_error(IDEAL, t, position, voltage, early=6)
    true = prediction_error(IDEAL, t, position, voltage)
    # The first six voltages are gone from the early log.
    np.testing.assert_allclose(late[200:], true[200:], atol=1e-6)
    assert np.sqrt(np.mean(early**2)) > 4.0 * np.sqrt(np.mean(late**2))
