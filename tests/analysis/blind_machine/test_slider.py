"""Physics of the blind machine's slider."""

import numpy as np
import pytest

from gapscope.analysis.blind_machine.motion import out_and_back
from gapscope.analysis.blind_machine.slider import (
    FORCE_PER_VOLT,
    KP,
    KV,
    Slider,
    run,
)

STROKE, RATE = 0.1, 0.5


def log(machine, cycles=2):
    t, share, curvature = out_and_back(RATE, cycles)
    readings, commands, _ = run(machine, STROKE * share, np.zeros(len(t)), 0.0)
    return t, STROKE * share, STROKE * curvature, readings, commands


def test_the_drive_command_obeys_the_stated_law():
    _, reference, _, q, u = log(Slider())
    filtered = 0.5 * (q[1:] + q[:-1])
    rate = np.diff(filtered) / 1e-3
    expected = KV * (KP * (reference[2:] - q[2:]) - rate)
    assert u[2:] == pytest.approx(expected, abs=1e-9)


def test_force_is_mass_and_viscous_friction():
    """Regressing force on measured speed and acceleration returns the machine's two parameters."""
    m = Slider(mass=90.0, viscous=250.0)
    _, _, _, q, u = log(m)
    # Force is held over [t, t + T]: the step of q over it is the speed it acts at.
    speed = np.diff(q) / 1e-3
    acceleration = np.gradient(speed, 1e-3)
    window = np.ones(25) / 25  # 5e-8 m counts differentiate to 0.05 m/s^2; smooth both sides alike
    smooth = [
        np.convolve(x, window, "valid") for x in (acceleration, speed, FORCE_PER_VOLT * u[:-1])
    ]
    fit, *_ = np.linalg.lstsq(np.column_stack(smooth[:2]), smooth[2], rcond=None)
    assert fit == pytest.approx((90.0, 250.0), rel=5e-3)


def test_dry_friction_reverses_with_motion():
    """Added force is the dry level against the motion, both ways, wherever speed is not small."""
    level = 20.0
    t, reference, _, _, u = log(Slider(coulomb=(level, level)))
    _, _, _, _, free = log(Slider())
    speed = np.gradient(reference, t)
    moving = np.abs(speed) > 0.5 * np.abs(speed).max()
    extra = FORCE_PER_VOLT * (u - free)
    assert np.mean(extra[moving] * np.sign(speed[moving])) == pytest.approx(level, rel=0.02)


def test_a_constant_force_is_held_by_the_drive():
    _, _, _, _, u = log(Slider(bias=15.0))
    assert FORCE_PER_VOLT * u[900:1000].mean() == pytest.approx(
        FORCE_PER_VOLT * log(Slider())[4][900:1000].mean() - 15.0, abs=0.1
    )
