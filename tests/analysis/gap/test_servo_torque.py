"""What an unsigned torque at rest says of a servo's error."""

from types import SimpleNamespace

import numpy as np

from gapscope.analysis.gap.machines import servo_torque

SAMPLES, STIFFNESS = 1000, 5.0


def resting(errors):
    """A run of an arm that never moves, with errors (joints, samples) [rad] that its servos see, and noise."""
    rng = np.random.default_rng(0)
    torque = STIFFNESS * np.abs(errors).T + rng.normal(0.0, 0.02, errors.T.shape)
    seen = errors + rng.normal(0.0, 2e-4, errors.shape)
    return SimpleNamespace(
        fine_reference=np.zeros_like(errors), fine_position=seen, torque=np.abs(torque)
    )


def test_joints_that_hold_unlike_loads_show_that_the_servo_sees_the_error():
    errors = np.array([[0.01], [-0.03], [0.05]]) * np.ones(SAMPLES)
    assert servo_torque.agreement([resting(errors)]) > 0.8
    assert servo_torque.loop_acts_on_log([resting(errors)])


def test_joints_of_equal_friction_show_nothing():
    """All stop at 0.02 rad: what differs is noise, which would have a correlation near zero."""
    errors = np.array([[0.02], [-0.02], [0.02]]) * np.ones(SAMPLES)
    assert servo_torque.agreement([resting(errors)]) is None
    assert not servo_torque.loop_acts_on_log([resting(errors)])
    assert servo_torque.torque_remarks(("a", "b", "c"), [resting(errors)]) == []
