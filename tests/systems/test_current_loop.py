"""The current loop: gains by placement of its pole, back-EMF, the limit of the voltage."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, Sine, TrajectorySource, VectorLogSink
from pydrake.trajectories import PiecewisePolynomial

from gapscope.models.dc_motor import DCMotor, current_gains
from gapscope.systems.servo.current_loop import CurrentLoop

MOTOR = DCMotor(resistance=2.0, inductance=10e-3, torque_constant=1.43, emf_constant=1.43)
LOOP = CurrentLoop(motor=MOTOR, bandwidth=2000.0, period=1e-4, voltage_limit=500.0)


def run(loop, command, rate, seconds):
    """Times, currents and voltages at the loop's samples, before each of its updates."""
    builder = DiagramBuilder()
    drive = builder.AddSystem(loop.build(1))
    speed = builder.AddSystem(ConstantVectorSource([rate]))
    asked = builder.AddSystem(command)
    builder.Connect(asked.get_output_port(0), drive.GetInputPort("command"))
    builder.Connect(speed.get_output_port(), drive.GetInputPort("joint_rate"))
    sinks = [builder.AddSystem(VectorLogSink(1, publish_period=loop.period)) for _ in "iv"]
    for name, sink in zip(("current", "voltage"), sinks):
        builder.Connect(drive.GetOutputPort(name), sink.get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(seconds)
    logs = [sink.FindLog(simulator.get_context()) for sink in sinks]
    return logs[0].sample_times(), *(log.data()[0] for log in logs)


def step(*levels, seconds):
    """A command that holds each level in turn."""
    breaks = np.linspace(0.0, seconds, len(levels) + 1)
    held = np.array([[*levels, levels[-1]]])
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(breaks, held))


def test_current_steps_as_the_lag_it_is_designed_as():
    t, current, _ = run(LOOP, step(3.0, seconds=4e-3), 0.0, 4e-3)
    assert current == pytest.approx(3.0 * (1.0 - np.exp(-LOOP.bandwidth * t)), abs=1e-3 * 3.0)


@pytest.mark.parametrize(("share", "gain"), [(0.2, 1.0 / np.sqrt(1.04)), (1.0, np.sqrt(0.5))])
def test_bandwidth_is_the_designed_one(share, gain):
    """Gain of a first-order lag at the bandwidth and below; the held command adds half a sample of delay only."""
    w = share * LOOP.bandwidth
    t, current, voltage = run(LOOP, Sine(1.0, w, 0.0, 1), 0.0, 6.0 * 2.0 * np.pi / w)
    assert np.abs(voltage).max() < LOOP.voltage_limit
    late = t > 3.0 * 2.0 * np.pi / w
    basis = np.column_stack([np.sin(w * t[late]), np.cos(w * t[late])])
    a, b = np.linalg.lstsq(basis, current[late], rcond=None)[0]
    assert np.hypot(a, b) == pytest.approx(gain, rel=0.01)


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_back_emf_is_borne_by_the_voltage(share):
    """Fed forward it leaves the current alone; else the integral learns it with the winding's pole, R/L."""
    loop = replace(LOOP, emf_share=share)
    t, current, voltage = run(loop, step(2.0, seconds=0.05), 100.0, 0.05)
    lag = 2.0 * (1.0 - np.exp(-LOOP.bandwidth * t))
    if share:
        assert current == pytest.approx(lag, abs=0.01)
    else:
        pole = MOTOR.resistance / MOTOR.inductance
        low = np.abs(current - lag)
        assert low.max() > 1.0
        early, late = (np.argmin(np.abs(t - x)) for x in (0.02, 0.03))
        assert low[late] / low[early] == pytest.approx(np.exp(-pole * 0.01), rel=0.01)
    assert voltage[-1] == pytest.approx(2.0 * MOTOR.resistance + 143.0, rel=1e-3)


def test_voltage_limits_the_current_and_the_integral_waits():
    """At 300 rad/s, 500 V leave (500 - 429) / 2 A of the 60 A asked for.

    An integral that had gone on would hold the voltage at its limit; one that waits is learnt within a few L/R = 5 ms.
    """
    t, current, voltage = run(LOOP, step(60.0, 5.0, seconds=0.12), 300.0, 0.12)
    assert voltage.max() == LOOP.voltage_limit
    before = t < 0.06 - 1e-9
    assert current[before][-1] == pytest.approx((500.0 - 429.0) / 2.0, rel=1e-3)
    assert current[t > 0.06 + 5.0 * 5e-3] == pytest.approx(5.0, abs=0.05)


def test_unusable_settings_are_refused():
    with pytest.raises(ValueError, match="bandwidth is 0"):
        current_gains(MOTOR, 0.0, 1e-4)
    with pytest.raises(ValueError, match="limit 0"):
        CurrentLoop(voltage_limit=0.0).build(1)
