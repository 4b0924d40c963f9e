"""Paths keep their profile, their shape, and derivatives that belong together."""

import numpy as np
import pytest

from gapscope.models.paths import Circle, Line, Trapezoid

PATHS = [
    Line(start=(-0.6, 0.9), end=(0.6, 0.9), feed=1.0, acceleration=1.0),
    Line(start=(0.1, 0.2), end=(0.3, 0.7), feed=2.0, acceleration=1.5),  # too short for its feed
    Circle(centre=(0.0, 0.8), radius=0.2, turns=2.0, feed=0.628, acceleration=5.0),
]


@pytest.mark.parametrize("path", PATHS)
def test_velocity_and_acceleration_are_derivatives(path):
    """Trapezoidal sums of the derivatives; the acceleration jumps, which costs one step of 1 ms."""
    t = np.arange(0.0, path.profile.duration + 0.1, 1e-3)
    x, v, a = path.sample(t)
    for f, df in ((x, v), (v, a)):
        sums = np.cumsum(0.5e-3 * (df[1:] + df[:-1]), axis=0)
        assert f[1:] - f[0] == pytest.approx(sums, abs=1e-2)
    assert np.linalg.norm(v, axis=1).max() <= path.feed * (1.0 + 1e-9)
    assert np.linalg.norm(v[-1]) == pytest.approx(0.0, abs=1e-12)


def test_line_ends_where_it_should_after_the_printed_time():
    """1.2 m at 1 m/s and 1 m/s^2: 2.2 s."""
    assert PATHS[0].profile.duration == pytest.approx(2.2)
    assert PATHS[0].sample(3.0)[0] == pytest.approx([0.6, 0.9])


def test_circle_stays_round_and_turns_left():
    t = np.linspace(0.0, PATHS[2].profile.duration, 500)
    x, v, _ = PATHS[2].sample(t)
    out = x - np.array([0.0, 0.8])
    assert np.linalg.norm(out, axis=1) == pytest.approx(np.full(500, 0.2))
    assert np.all(out[1:-1, 0] * v[1:-1, 1] - out[1:-1, 1] * v[1:-1, 0] > 0.0)


def test_lengths_must_be_positive():
    with pytest.raises(ValueError, match=r"length is 0\.0"):
        Trapezoid(length=0.0, feed=1.0, acceleration=1.0)
