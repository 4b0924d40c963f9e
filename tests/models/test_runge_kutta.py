"""The Runge-Kutta step on a driven oscillator whose motion is known."""

import numpy as np
import pytest

from gapscope.models.runge_kutta import ode4_step, work_arrays

STIFFNESS = 25.0


def law(q, v, held, torque, t, stiffness, scratch, out):
    """A spring, a held force and a torque that follows time."""
    for j in range(q.shape[0]):
        out[j] = -stiffness * q[j] - held[j] + torque[j] * np.sin(t)


def error(steps, work):
    """Largest error after two seconds."""
    q, v = np.array([1.0, 0.0]), np.array([0.0, 2.0])
    held, torque = np.array([0.5, 0.0]), np.array([0.0, 3.0])
    dt, w = 2.0 / steps, np.sqrt(STIFFNESS)
    for k in range(steps):
        ode4_step(law, 2, q, v, held, torque, k * dt, dt, STIFFNESS, None, work)
    rest = -0.5 / STIFFNESS
    driven = 3.0 / (STIFFNESS - 1.0)
    exact = [
        rest + (1.0 - rest) * np.cos(2.0 * w),
        driven * np.sin(2.0) + (2.0 - driven) / w * np.sin(2.0 * w),
    ]
    return np.abs(q - exact).max()


@pytest.mark.parametrize("work", [work_arrays(2), np.zeros((5, 2))])
def test_halving_the_step_divides_the_error_by_sixteen(work):
    coarse, fine = error(200, work), error(400, work)
    assert coarse < 1e-5
    assert coarse / fine == pytest.approx(16.0, rel=0.1)
