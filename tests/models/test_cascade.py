"""Laws of the cascade: gains, saturation, and an integral that waits."""

import numpy as np
import pytest

from gapscope.models import cascade
from gapscope.models.servo_axis import ServoAxis


def test_rate_command_goes_through_the_gear():
    assert cascade.rate_command(1.0, 0.9, 2.0, 20.0, 0.5, 0.025) == pytest.approx(120.0)


def test_integral_waits_while_the_output_is_clipped():
    output, integral = cascade.proportional_integral(3.0, 0.2, 1.0, 10.0, 4.0, 0.01)
    assert (output, integral) == (4.0, 0.2)
    output, integral = cascade.proportional_integral(-1.0, 0.7, 1.0, 10.0, 4.0, 0.01)
    assert (output, integral) == (4.0, pytest.approx(0.69))  # unwinds while clipped
    output, integral = cascade.proportional_integral(0.1, 0.2, 1.0, 10.0, np.inf, 0.01)
    assert (output, integral) == (pytest.approx(2.1), pytest.approx(0.201))


def test_axis_balances_its_torques():
    """At constant speed the current carries friction (4.10) and the machine's load through the gear."""
    axis = ServoAxis()
    rate, load = 100.0, 40.0
    current = (0.17 + 0.478 + load / 40.0) / 1.43
    assert axis.motor_acceleration(rate, current, load) == pytest.approx(0.0, abs=1e-9)
    assert axis.joint_inertia == pytest.approx(13e-4 * 1600.0)
    with pytest.raises(ValueError, match="inertia is 0"):
        ServoAxis(inertia=0.0)
    with pytest.raises(ValueError, match="negative"):
        ServoAxis(coulomb=-1.0)
