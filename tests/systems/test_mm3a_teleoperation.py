"""A hand's velocity command moves the tip."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from gapscope.diagrams.mm3a import teleoperation
from gapscope.models.mm3a import kinematics
from gapscope.models.mm3a.arm import Arm
from gapscope.models.mm3a.stepper import Conditions
from gapscope.systems.mm3a.stepper import EmpiricalStepper, PhysicalStepper
from gapscope.systems.mm3a.teleoperation import VelocityToSteps

ARM = Arm()
START = (0.2, -1.3, 0.006)


def drive(stepper, velocity, duration, start=START, **belief):
    diagram = teleoperation(stepper, start, **belief)
    simulator = Simulator(diagram)
    context = simulator.get_mutable_context()
    diagram.GetInputPort("velocity").FixValue(context, velocity)
    simulator.AdvanceTo(duration)
    return {
        name: np.array(diagram.GetOutputPort(name).Eval(context))
        for name in ("joints", "tip", "believed")
    }


def test_tip_follows_the_commanded_velocity():
    """Within one step of each joint at the tip after 3 s, with the true model."""
    velocity = np.array([30e-6, -20e-6, 25e-6])
    end = drive(EmpiricalStepper(START), velocity, 3.0)
    moved = end["tip"] - kinematics.tip(START, ARM)
    assert np.linalg.norm(moved - 3.0 * velocity) < 0.050 * 98e-6 + 0.040 * 110e-6 + 1.2e-6
    # The stepper plays a command one tick after it was believed.
    assert np.all(np.abs(end["joints"] - end["believed"]) < [120e-6, 120e-6, 1.4e-6])


def test_too_fast_a_command_is_slowed_but_not_bent():
    velocity = np.array([2e-3, 0.0, 2e-3])
    end = drive(EmpiricalStepper(START), velocity, 2.0)
    moved = end["tip"] - kinematics.tip(START, ARM)
    direction = moved / np.linalg.norm(moved)
    assert np.linalg.norm(moved) < 0.2 * 2.0 * np.linalg.norm(velocity)
    assert direction @ velocity / np.linalg.norm(velocity) > 0.995


def test_a_joint_limit_stops_the_belief_too():
    start = (0.0, -np.pi / 2, 0.01199)
    end = drive(EmpiricalStepper(start), [50e-6, 0.0, 0.0], 3.0, start=start)
    assert end["believed"][2] <= ARM.upper_3
    assert end["believed"][2] == pytest.approx(end["joints"][2], abs=1e-6)


def test_dead_reckoning_drifts_when_the_day_has_changed():
    end = drive(
        EmpiricalStepper(START, conditions=Conditions(scale=((1.1, 1.1),) * 3)),
        [0.0, 0.0, 40e-6],
        4.0,
    )
    moved = end["tip"][2] - kinematics.tip(START, ARM)[2]
    assert moved == pytest.approx(1.1 * 4.0 * 40e-6, rel=0.08)


def test_physical_actuators_are_driven_through_the_same_ports():
    end = drive(PhysicalStepper(START), [20e-6, 0.0, 0.0], 1.0)
    assert end["tip"][0] - kinematics.tip(START, ARM)[0] > 10e-6


def test_start_outside_the_limits_is_refused():
    with pytest.raises(ValueError, match="teleoperation: start"):
        VelocityToSteps((0.0, 2.0, 0.0))
