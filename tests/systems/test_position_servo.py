"""A joint on a position servo: the block and the compiled loop share one law."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from gapscope.models import position_servo, position_servo_kernel
from gapscope.systems.position_servo import ServoJoint

DT, SAMPLES = 0.02, 60
SERVO = position_servo.PositionServo(
    damping=0.05, inertia=2e-3, level=0.01, share=0.2, speed_limit=2.0, error_limit=0.5,
    delay=0.0, lag=0.03, gap=0.02, scale_error=0.01, zero=0.1,
)  # fmt: skip


def test_block_and_compiled_loop_agree():
    """Friction, both limits, lag, clearance and errors of the sensor at once, to the last bits."""
    t = DT * np.arange(SAMPLES)
    reference, load = 0.4 + np.sign(np.sin(3.0 * t)), 0.05 * np.cos(5.0 * t)
    expected = np.full(SAMPLES, reference[0])
    position_servo_kernel.simulate(reference, load, SERVO, DT, 1, 1, expected)
    joint = ServoJoint(SERVO, DT, start=reference[0])
    simulator = Simulator(joint)
    context, found = simulator.get_mutable_context(), []
    for k in range(1, SAMPLES):
        for name, signal in (("reference", reference), ("load", load)):
            joint.GetInputPort(name).FixValue(context, signal[k : k + 1])
        simulator.AdvanceTo((k - 0.5) * DT)
        found.append(joint.GetOutputPort("angle").Eval(context)[0])
    assert found == pytest.approx(expected[1:], abs=1e-13)
    assert np.ptp(expected) > 1.0


def test_a_delay_is_refused():
    with pytest.raises(ValueError, match=r"delay is 0\.1 s; expected 0"):
        ServoJoint(SERVO._replace(delay=0.1), DT)
