"""The stepper systems of the MM3A and the audio limit switch behind them."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, TrajectorySource, VectorLogSink
from pydrake.trajectories import PiecewisePolynomial

from gapscope.models.mm3a import actuators, stepper
from gapscope.models.mm3a.arm import Arm, gravity_in_base
from gapscope.models.mm3a.limit_switch import heard_steps
from gapscope.models.mm3a.step_size import STEP_TIME
from gapscope.models.mm3a.stepper import Conditions
from gapscope.systems.mm3a.limit_switch import AudioLimitSwitch
from gapscope.systems.mm3a.stepper import EmpiricalStepper, PhysicalStepper

ARM = Arm()
LEVEL = (0.0, -np.pi / 2, 0.006)


def play(system, commands, prepare=lambda context: None):
    """Joints after each tick when ``system`` gets the rows of ``commands``."""
    builder = DiagramBuilder()
    builder.AddSystem(system)
    ticks = np.arange(len(commands) + 1) * STEP_TIME - 0.5 * STEP_TIME
    held = np.vstack([commands, commands[-1:]]).T.astype(float)
    source = builder.AddSystem(TrajectorySource(PiecewisePolynomial.ZeroOrderHold(ticks, held)))
    builder.Connect(source.get_output_port(), system.GetInputPort("commands"))
    sink = builder.AddSystem(VectorLogSink(3, STEP_TIME))
    builder.Connect(system.GetOutputPort("joints"), sink.get_input_port())
    diagram = builder.Build()
    simulator = Simulator(diagram)
    prepare(system.GetMyMutableContextFromRoot(simulator.get_mutable_context()))
    simulator.AdvanceTo(len(commands) * STEP_TIME)
    log = sink.FindLog(simulator.get_context()).data().T
    return log[1 : len(commands) + 1]


def test_empirical_system_plays_what_the_compiled_loop_plays():
    rng = np.random.default_rng(0)
    commands = rng.integers(-1, 2, (200, 3))
    conditions = Conditions(
        theta=0.4,
        psi=-0.2,
        scale=((0.9, 1.1), (1.05, 0.95), (1.2, 0.8)),
        heating=(0.01, 0.02, 0.03),
        reversal_loss=(0.1, 0.2, 0.3),
    )
    joints = play(EmpiricalStepper(LEVEL, conditions=conditions), commands)
    expected = stepper.run(commands, LEVEL, conditions=conditions).positions[1:]
    np.testing.assert_allclose(joints, expected, rtol=1e-13)


def test_tilt_and_factors_of_the_day_are_parameters_of_the_context():
    commands = np.tile([1, -1, 1], (20, 1))
    scale = np.full((3, 2), 1.25)

    def prepare(system):
        def change(context):
            system.set_tilt(context, -0.7, 0.3)
            system.set_scale(context, scale)

        return change

    system = EmpiricalStepper(LEVEL)
    joints = play(system, commands, prepare(system))
    conditions = Conditions(theta=-0.7, psi=0.3, scale=tuple(map(tuple, scale)))
    expected = stepper.run(commands, LEVEL, conditions=conditions).positions[1:]
    np.testing.assert_allclose(joints, expected, rtol=1e-13)


def test_physical_system_settles_on_the_step_of_its_actuators():
    """After the direction memory has faded, each step is the settled one of the posture."""
    commands = np.tile([1, -1, 1], (40, 1))
    joints = play(PhysicalStepper(LEVEL), commands)
    steps = np.diff(joints, axis=0)[-4:].mean(axis=0)
    gravity, parts = gravity_in_base(0.0, 0.0), actuators.joint_actuators()
    for joint, direction in enumerate((1, -1, 1)):
        expected = actuators.physical_step(
            joint, direction, joints[-1], gravity, (0, 0, 0), ARM, parts
        )
        # The posture drifts by 4 mrad over the run and the memory keeps some 1e-3.
        assert steps[joint] == pytest.approx(expected, rel=5e-3)


def test_both_models_have_the_same_ports():
    systems = (EmpiricalStepper(LEVEL), PhysicalStepper(LEVEL))
    names = [
        (
            [s.get_input_port(i).get_name() for i in range(s.num_input_ports())],
            [s.get_output_port(i).get_name() for i in range(s.num_output_ports())],
        )
        for s in systems
    ]
    assert names[0] == names[1]
    assert names[0] == (["commands", "fine", "force"], ["joints", "motion", "stopped", "taken"])


def test_physical_actuator_remembers_its_direction():
    """The first step after a reversal differs from the settled one; the empirical law needs a term."""
    commands = np.tile([0, 0, 1], (30, 1))
    commands[15:, 2] = -1
    motion = np.diff(play(PhysicalStepper(LEVEL), commands)[:, 2])
    first_back, settled_back = motion[14], motion[-1]
    assert abs(first_back / settled_back - 1.0) > 0.05
    assert abs(motion[-2] / settled_back - 1.0) < 0.01


def test_force_on_the_tip_loads_the_joints():
    system = EmpiricalStepper(LEVEL)
    builder = DiagramBuilder()
    builder.AddSystem(system)
    for name, value in (("commands", [0.0, 0.0, 1.0]), ("force", [-0.005, 0.0, 0.0])):
        source = builder.AddSystem(ConstantVectorSource(value))
        builder.Connect(source.get_output_port(), system.GetInputPort(name))
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(STEP_TIME * 0.5)
    context = system.GetMyContextFromRoot(simulator.get_context())
    motion = system.GetOutputPort("motion").Eval(context)[2]
    # Pushed inward by 5 mN, a quarter of the weight of link 3, on its way out.
    expected = 972e-9 - 375.55e-9 * 0.005 / (ARM.mass_3 * 9.81)
    assert motion == pytest.approx(expected, rel=1e-12)


def test_fine_steps_add_to_the_joint_and_saturate():
    system = EmpiricalStepper(LEVEL)
    builder = DiagramBuilder()
    builder.AddSystem(system)
    for name, value in (("commands", [0.0, 0.0, 0.0]), ("fine", [10.0, 0.0, -500.0])):
        source = builder.AddSystem(ConstantVectorSource(value))
        builder.Connect(source.get_output_port(), system.GetInputPort(name))
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(9.5 * STEP_TIME)
    context = system.GetMyContextFromRoot(simulator.get_context())
    joints = system.GetOutputPort("joints").Eval(context) - LEVEL
    np.testing.assert_allclose(joints, [10 * 10 * 1e-7, 0.0, -0.5e-6], atol=1e-17)


@pytest.mark.parametrize("free_steps", [10, 12, 14])
def test_limit_switch_hears_the_stop_within_five_steps(free_steps):
    """System and counting rule agree: the stop is reported at the end of the recording it is in."""
    start = (0.0, -np.pi / 2, (free_steps + 0.5) * 899e-9)
    system, switch = EmpiricalStepper(start), AudioLimitSwitch()
    builder = DiagramBuilder()
    builder.AddSystem(system)
    builder.AddSystem(switch)
    source = builder.AddSystem(ConstantVectorSource([0.0, 0.0, -1.0]))
    builder.Connect(source.get_output_port(), system.GetInputPort("commands"))
    for name in ("stopped", "taken"):
        builder.Connect(system.GetOutputPort(name), switch.GetInputPort(name))
    simulator = Simulator(builder.Build())
    context = switch.GetMyContextFromRoot(simulator.get_context())
    steps = 0
    while switch.GetOutputPort("detected").Eval(context)[2] == 0.0:
        steps += 1
        simulator.AdvanceTo((steps - 0.25) * STEP_TIME)
    assert steps == heard_steps(free_steps + 1)
    assert 0 <= steps - (free_steps + 1) < 5


def test_commands_other_than_one_step_are_refused():
    system = EmpiricalStepper(LEVEL)
    context = system.CreateDefaultContext()
    system.GetInputPort("commands").FixValue(context, [0.0, 0.5, 0.0])
    with pytest.raises(ValueError, match="expected -1, 0 or 1"):
        Simulator(system, context).AdvanceTo(0.01)


def test_start_outside_the_limits_is_refused():
    with pytest.raises(ValueError, match="outside the joint limits"):
        EmpiricalStepper((0.0, 1.0, 0.0))
    with pytest.raises(ValueError, match="terms of the empirical law"):
        PhysicalStepper(LEVEL, conditions=Conditions(heating=(0.1, 0.0, 0.0)))
