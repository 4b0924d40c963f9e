"""The piezo stack follows the laws of its operators, and is linear where it should be."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from gapscope.models import hysteresis, piezo_stack, piezo_stack_kernel

T = np.arange(0.0, 3.0, 0.005)
COMMAND = 1.8 + 1.8 * np.sin(2.0 * np.pi * T)
DECADES = np.array(piezo_stack.DECADES)
LINEAR = piezo_stack.linear_stack(gain=12.0, offset=-120.0, before=1.8)._replace(middle=1.8)
STOPS = LINEAR._replace(limits=np.array([0.4, 1.2]), shares=np.array([0.2, 0.1]))
BOUC_WEN = LINEAR._replace(alpha=0.3, beta=0.5, gamma=0.1)


def length(stack, t=T, command=COMMAND):
    out = np.empty_like(t)
    piezo_stack_kernel.simulate(t, command, stack, DECADES, out)
    return out


def lost(stack, t=T, command=COMMAND):
    """Voltage that hysteresis takes."""
    return command - (length(stack, t, command) - stack.offset) / stack.gain


def test_a_linear_stack_follows_its_command():
    np.testing.assert_allclose(length(LINEAR), -120.0 + 12.0 * COMMAND, rtol=1e-14)


@pytest.mark.parametrize("stack", [STOPS, BOUC_WEN], ids=["stops", "Bouc-Wen"])
def test_hysteresis_does_not_depend_on_the_rate(stack):
    np.testing.assert_allclose(length(stack, 7.0 * T), length(stack), rtol=0.0, atol=1e-11)


@pytest.mark.parametrize("stack", [STOPS, BOUC_WEN], ids=["stops", "Bouc-Wen"])
def test_hysteresis_dissipates_in_every_closed_cycle(stack):
    v = lost(stack)[200:401]  # the second cycle
    assert np.sum(0.5 * (v[1:] + v[:-1]) * np.diff(COMMAND[200:401])) > 0.0


def test_a_stop_complements_the_play_operator():
    play = expected = 0.0
    element = 0.0
    drive = np.concatenate([[0.0], np.random.default_rng(0).normal(0.0, 1.0, 200).cumsum()])
    for change, value in zip(np.diff(drive), drive[1:]):
        element = hysteresis.stop(element, change, 0.7)
        play = max(value - 0.7, min(value + 0.7, play))
        expected = value - play
        assert element == pytest.approx(expected, abs=1e-12)


def test_a_loop_of_stops_has_the_area_of_its_saturated_elements():
    # An element of limit r in a sweep of half-span A > r encloses 4 r (A - r).
    v, u = lost(STOPS)[200:401], COMMAND[200:401]  # the second cycle
    area = np.sum(0.5 * (v[1:] + v[:-1]) * np.diff(u))
    expected = 4.0 * (0.2 * 0.4 * (1.8 - 0.4) + 0.1 * 1.2 * (1.8 - 1.2))
    # The trapezoid cuts the corners: an error of the order of the steps, 0.06 V, squared.
    assert area == pytest.approx(expected, rel=0.06**2)


def test_bouc_wen_agrees_with_an_adaptive_integrator():
    def rate(t, v):
        drive_rate = 3.6 * np.pi * np.cos(2.0 * np.pi * t)
        return hysteresis.bouc_wen_rate(v, drive_rate, 0.3, 0.5, 0.1)

    solution = solve_ivp(rate, (0.0, T[-1]), [0.0], t_eval=T, rtol=1e-9, atol=1e-11, max_step=1e-3)
    np.testing.assert_allclose(lost(BOUC_WEN), solution.y[0], atol=1e-5)


def test_the_lag_answers_a_step_and_a_ramp_as_its_closed_form():
    step = LINEAR._replace(before=0.0, lag=0.02)
    t, ones = T[:100], np.ones(100)
    expected = -120.0 + 12.0 * (1.0 - np.exp(-t / 0.02))
    np.testing.assert_allclose(length(step, t, ones), expected, rtol=1e-12)
    late = length(step, T, 2.0 * T)[-1]
    assert late == pytest.approx(-120.0 + 24.0 * (T[-1] - 0.02), rel=1e-12)


def test_two_stages_share_the_lag():
    stack = LINEAR._replace(before=0.0, lag=0.04, stages=2)
    x = T[:200] / 0.02
    expected = -120.0 + 12.0 * (1.0 - (1.0 + x) * np.exp(-x))
    # Between samples the second stage sees a straight line where the first bends:
    # h^2/8 times its largest curvature of 1/(0.02 s)^2.
    bound = 12.0 * 0.005**2 / 8.0 / 0.02**2
    np.testing.assert_allclose(length(stack, T[:200], np.ones(200)), expected, atol=bound)


def test_a_delay_shifts_the_command():
    late = length(LINEAR._replace(delay=0.01))
    np.testing.assert_allclose(late[2:], length(LINEAR)[:-2], rtol=1e-12)


def test_creep_grows_by_its_share_in_a_decade_of_time():
    t = np.arange(0.0, 40.0, 0.005)
    stack = LINEAR._replace(before=0.0, creep=0.015)
    y = length(stack, t, np.ones_like(t))
    grown = np.interp([2.0, 20.0], t, y)
    # One Kelvin-Voigt element a decade ripples about the logarithm by less than 15 %.
    assert grown[1] - grown[0] == pytest.approx(0.015 * 12.0, rel=0.15)
