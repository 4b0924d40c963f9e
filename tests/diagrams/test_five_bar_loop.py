"""The five-bar's mechatronic diagram: schemes, and the machine as a disturbance against one plant."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from gapscope.diagrams.five_bar_loop import Coupling, FiveBarLoop, Scheme, build
from gapscope.models.parallel.five_bar import FiveBar
from gapscope.models.parallel.machine import FiveBarMachine, joint_motion
from gapscope.models.paths import Line
from gapscope.models.servo_axis import ServoAxis
from gapscope.systems.servo.current_loop import CurrentLoop
from gapscope.systems.servo.pi_loop import PILoop
from gapscope.systems.servo.position_loop import PositionLoop

PATH = Line(start=(-0.1, 0.8), end=(0.1, 0.85), feed=1.0, acceleration=20.0)
SLIM = ServoAxis(coulomb=0.0, viscous=0.0)
STEP = 2.5e-4


def after(loop, seconds=0.1):
    """Joint positions and tool error at the end of a short run."""
    diagram = build(loop, PATH)
    simulator = Simulator(diagram)
    ResetIntegratorFromFlags(simulator, "runge_kutta2", loop.step)
    with np.errstate(all="ignore"):
        simulator.AdvanceTo(seconds)
    context = simulator.get_context()
    read = lambda name: np.array(diagram.GetOutputPort(name).Eval(context))  # noqa: E731
    return read("joint_position"), read("position") - read("reference")


@pytest.mark.parametrize("scheme", list(Scheme))
def test_every_scheme_follows_the_path(scheme):
    """Computed torque knows the machine: within 0.1 mm. The cascades lag by about v / k_v."""
    loop = FiveBarLoop(scheme=scheme, step=STEP, velocity_period=STEP, position_period=2e-3)
    _, error = after(loop)
    lag = np.linalg.norm(PATH.sample(0.1)[1]) / loop.position_gain
    computed = scheme in (Scheme.torque, Scheme.torque_workspace)
    assert np.linalg.norm(error) < (1e-4 if computed else 2.5 * lag)


def test_disturbance_tends_to_the_coupled_plant_with_its_step():
    """The load is one step late: half the step, half the difference, to a fifth of it."""
    base = FiveBarLoop(axis=SLIM, scheme=Scheme.joint, velocity_period=1e-3)
    plant, _ = after(replace(base, coupling=Coupling.plant, step=1.25e-4))
    late = [np.linalg.norm(after(replace(base, step=step))[0] - plant) for step in (5e-4, 2.5e-4)]
    assert late[0] > 1e-7
    assert late[1] / late[0] == pytest.approx(0.5, abs=0.1)


def test_disturbance_diverges_once_the_machine_outweighs_its_axes():
    """The late load is an iteration a <- -(I / J) a: it fails beyond I = J, where one plant does not."""
    heavy = FiveBarMachine(geometry=FiveBar(masses=(0.49, 0.57, 0.57, 0.49, 8.0)))
    base = FiveBarLoop(axis=SLIM, machine=heavy, step=STEP, velocity_period=1e-3)
    q = heavy.inverse([-0.1, 0.8])
    assert np.linalg.eigvalsh(heavy.equations(q, 0.0 * q).inertia)[-1] > SLIM.joint_inertia
    plant, error = after(replace(base, coupling=Coupling.plant))
    assert np.isfinite(plant).all()
    assert np.linalg.norm(error) < 0.1
    diverged, _ = after(base, 0.03)
    assert not np.abs(diverged - q).max() < 1.0


def test_path_out_of_reach_is_refused():
    with pytest.raises(ValueError, match="expected a point in reach"):
        build(FiveBarLoop(), Line(start=(3.0, 0.0), end=(0.0, 0.8), feed=1.0, acceleration=1.0))


def test_joint_motion_carries_the_tool_along_its_path():
    machine = FiveBarMachine()
    x, v, a = PATH.sample(np.array([0.05, 0.1]))
    q, rate, acceleration = joint_motion(machine, x, v, a)
    assert machine.forward(q) == pytest.approx(x)
    for i in range(2):
        jacobian, drift = machine.task_motion(q[i], rate[i])
        assert jacobian @ rate[i] == pytest.approx(v[i])
        assert jacobian @ acceleration[i] + drift == pytest.approx(a[i], abs=1e-9)


def outputs(system, inputs, port, steps, period):
    builder = DiagramBuilder()
    builder.AddSystem(system)
    for name, value in inputs.items():
        source = builder.AddSystem(ConstantVectorSource(np.atleast_1d(value)))
        builder.Connect(source.get_output_port(), system.GetInputPort(name))
    builder.ExportOutput(system.GetOutputPort(port), port)
    diagram = builder.Build()
    simulator = Simulator(diagram)
    found = []
    for k in range(steps):
        simulator.AdvanceTo((k + 0.5) * period)
        found.append(float(diagram.get_output_port(0).Eval(simulator.get_context())[0]))
    return np.array(found)


def test_pi_loop_integrates_clips_and_filters():
    loop = PILoop(1, period=0.01, kp=2.0, ki=10.0, limit=2.5)
    found = outputs(loop, {"command": 1.0, "measured": 0.0}, "output", 6, 0.01)
    assert found == pytest.approx([2.0, 2.1, 2.2, 2.3, 2.4, 2.5])
    slow = PILoop(1, period=0.01, kp=1.0, ki=0.0, filter_time=0.02)
    found = outputs(slow, {"command": 0.0, "measured": 1.0}, "output", 3, 0.01)
    assert found == pytest.approx(np.exp(-0.5 * np.arange(1, 4)) - 1.0)


def test_position_loop_holds_and_filters():
    loop = PositionLoop(1, period=0.01, gain=5.0, per_motor=0.1, feedforward=1.0, filter_time=0.01)
    inputs = {"reference": 1.0, "reference_rate": 2.0, "joint_position": 0.8}
    found = outputs(loop, inputs, "motor_rate", 3, 0.01)
    assert found == pytest.approx(30.0 * (1.0 - np.exp(-np.arange(1.0, 4.0))))


def test_gains_and_periods_are_checked():
    with pytest.raises(ValueError, match="gain -1"):
        PositionLoop(1, period=0.01, gain=-1.0, per_motor=1.0)
    with pytest.raises(ValueError, match="limit 0"):
        PILoop(1, period=0.01, kp=1.0, ki=0.0, limit=0.0)
    with pytest.raises(ValueError, match="period is 0"):
        PILoop(1, period=0.0, kp=1.0, ki=0.0)


@pytest.mark.parametrize("scheme", [Scheme.joint, Scheme.torque])
def test_fast_current_loop_tends_to_the_ideal_torque_source(scheme):
    """The current lags by 1/bandwidth: twice the bandwidth, half the difference; 0.1 mrad at 640 Hz."""
    base = FiveBarLoop(
        axis=SLIM, scheme=scheme, coupling=Coupling.plant, step=STEP, velocity_period=STEP
    )
    ideal, _ = after(base, 0.05)
    apart = []
    for bandwidth in (2000.0, 4000.0):
        inner = CurrentLoop(bandwidth=bandwidth, period=0.25 * STEP)
        apart.append(np.abs(after(replace(base, current_loop=inner), 0.05)[0] - ideal).max())
    assert apart[1] / apart[0] == pytest.approx(0.5, abs=0.1)
    assert apart[1] < 1e-4
