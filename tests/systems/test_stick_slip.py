"""Event-resolved Drake simulation of the stick-slip actuator against the compiled fixed-step loop."""

import numpy as np
import pytest

from gapscope.diagrams.stick_slip import stick_slip_simulator
from gapscope.models.stick_slip import Actuator, Sawtooth, simulate
from gapscope.systems.stick_slip import StickSlipActuator

DRIVE = Sawtooth(period=0.002)


def steps_by_drake(actuator, direction, load, count):
    simulator = stick_slip_simulator(actuator, DRIVE, direction=direction, load=load)
    position = simulator.get_system().GetOutputPort("position")
    positions = [0.0]
    for k in range(1, count + 1):
        simulator.AdvanceTo(k * DRIVE.period)
        positions.append(position.Eval(simulator.get_context())[0])
    return np.diff(positions)


@pytest.mark.parametrize("direction", [1, -1])
@pytest.mark.parametrize(
    ("kind", "tolerance"),
    [
        # Loop error is of second order in its 0.5 us step where the kinks are in the contact alone.
        ("none", 1e-4),
        ("bouc_wen", 1e-4),
        # A Maxwell element that yields inside a step has overshot by O(step): first order.
        ("maxwell", 2e-3),
    ],
)
def test_events_and_fixed_steps_agree(kind, tolerance, direction):
    actuator = Actuator(hysteresis=kind)
    by_events = steps_by_drake(actuator, direction, 0.01, 3)
    by_loop = simulate(
        actuator, DRIVE, steps=3, direction=direction, load=0.01, time_step=5e-7
    ).steps
    np.testing.assert_allclose(by_events, by_loop, rtol=tolerance)


def test_contact_sticks_along_the_ramp_and_slips_in_the_flyback():
    simulator = stick_slip_simulator(Actuator(), DRIVE)
    diagram, context = simulator.get_system(), simulator.get_context()
    slipping = diagram.GetOutputPort("slipping")
    ramp_end = DRIVE.period + DRIVE.period - DRIVE.flyback
    simulator.AdvanceTo(ramp_end - 1e-5)
    assert slipping.Eval(context)[0] == 0.0
    simulator.AdvanceTo(ramp_end + 0.5 * DRIVE.flyback)
    assert slipping.Eval(context)[0] == 1.0


def test_ports_are_named():
    system = StickSlipActuator()
    assert system.GetInputPort("load").size() == 1
    assert [system.GetOutputPort(n).size() for n in ("position", "state", "slipping")] == [1, 8, 1]
    with pytest.raises(ValueError, match="expected -1 or 1"):
        StickSlipActuator(direction=0)
