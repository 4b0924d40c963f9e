"""The Diagram of the PepperMill-Carrier's loop against the compiled loop."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from gapscope.diagrams.pmc_loop import PMCLoopConfig, pmc_loop
from gapscope.models.pmc import constants, dynamics, simulation
from gapscope.models.pmc.controllers import CONTROLLERS
from gapscope.systems.pmc_carrier import Carrier, SampledCarrier


@pytest.mark.parametrize("name", list(CONTROLLERS))
@pytest.mark.parametrize("cycle", ["industry", "smooth"])
def test_the_diagram_repeats_the_compiled_loop(name, cycle):
    """Same laws, step and order of operations: equal to 1e-11 over the first 200 samples."""
    config = PMCLoopConfig(controller=name, cycle=cycle, model_error=0.05)
    machine = config.machine()
    diagram = pmc_loop(config)
    simulator = Simulator(diagram)
    simulator.Initialize()
    simulator.AdvanceTo(0.2)
    context = simulator.get_context()
    reference = simulation.sample_cycle(config.motion(machine), machine, cycles=0.1)
    batch = simulation.run(
        reference, CONTROLLERS[name], machine, believed=machine.heavier(config.model_error)
    )
    joints = diagram.GetOutputPort("joints").Eval(context)
    # AdvanceTo leaves the update of the last sample to the next call.
    assert joints == pytest.approx(batch.joints[200], abs=1e-11)
    rates = diagram.GetOutputPort("rates").Eval(context)
    assert rates == pytest.approx(batch.joint_rates[200], abs=1e-9)


def test_continuous_carrier_in_all_scalars():
    """Float, AutoDiffXd and Expression give the same derivative; the gradient is that of differences."""
    from pydrake.autodiffutils import InitializeAutoDiff
    from pydrake.symbolic import Variable

    machine = PMCLoopConfig().machine()
    carrier = Carrier(machine)
    x = np.array([0.3, 0.25, 0.2, 1.3, 0.1, -0.2, 0.5, 0.3])
    torque = np.array([1.0, -0.5, 2.0, 0.3])

    def derivative(system, state, context=None):
        context = system.CreateDefaultContext()
        context.SetContinuousState(state)
        system.GetInputPort("torque").FixValue(context, torque)
        return system.EvalTimeDerivatives(context).CopyToVector()

    exact = derivative(carrier, x)
    gradient = derivative(carrier.ToAutoDiffXd(), InitializeAutoDiff(x).ravel())
    assert [a.value() for a in gradient] == pytest.approx(exact)
    step = 1e-6
    for j in range(8):
        shift = step * np.eye(8)[j]
        difference = (derivative(carrier, x + shift) - derivative(carrier, x - shift)) / (2 * step)
        assert [a.derivatives()[j] for a in gradient] == pytest.approx(
            difference, rel=1e-5, abs=1e-4
        )
    names = [Variable(f"x{i}") for i in range(8)]
    symbolic = derivative(carrier.ToSymbolic(), np.array(names))
    at = dict(zip(names, x))
    assert [e.Evaluate(at) for e in symbolic] == pytest.approx(exact)


def test_constants_live_in_the_context():
    machine = PMCLoopConfig().machine()
    home = np.array([0.299, 0.299, 0.0, np.pi / 2])
    carrier = SampledCarrier(machine, home, home, 1e-3)
    context = carrier.CreateDefaultContext()
    heavy = constants.of(replace(machine, payload=1.0))
    context.get_mutable_numeric_parameter(carrier.CONSTANTS).SetFromVector(
        constants.to_vector(heavy)
    )
    carrier.GetInputPort("torque").FixValue(context, np.zeros(4))
    updated = carrier.EvalUniquePeriodicDiscreteUpdate(context).value()
    falling = dynamics.acceleration(home, np.zeros(4), np.zeros(4), heavy)
    assert updated[6] / 1e-3 == pytest.approx(falling[2], rel=0.02)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"controller": "lqr"}, "expected one of ts, pd, ct, ra"),
        ({"cycle": "square"}, "expected one of industry, smooth"),
        ({"speed": 0.0}, "speed is 0.0"),
        ({"model_error": 2.0}, "model_error is 2.0"),
    ],
)
def test_settings_without_a_loop_are_refused(change, message):
    with pytest.raises(ValueError, match=message):
        pmc_loop(PMCLoopConfig(**change))


def test_config_from_yaml(tmp_path):
    path = tmp_path / "loop.yaml"
    path.write_text("controller: ra\nplacement: {z: -0.3}\n")
    config = PMCLoopConfig.load(path)
    assert (config.controller, config.placement.z, config.cycle) == ("ra", -0.3, "industry")
    path.write_text("kontroller: ra\n")
    with pytest.raises(ValueError, match="kontroller"):
        PMCLoopConfig.load(path)
