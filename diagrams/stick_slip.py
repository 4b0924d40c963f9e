"""The stick-slip actuator under a constant load, ready to simulate with event resolution."""

from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource

from ..models.stick_slip import Actuator, Sawtooth
from ..systems.stick_slip import StickSlipActuator

LONGEST_STEP = 2.0e-5  # shorter than any witness crossing and recrossing [s]
ACCURACY = 1.0e-7  # relative, of the integrator
ISOLATION = 1.0e-5  # of a witness crossing within a step, relative to the time scale of the step


def stick_slip_simulator(
    actuator: Actuator, drive: Sawtooth, *, direction: int = 1, load: float = 0.0
) -> Simulator:
    """Simulator of a diagram with outputs ``position``, ``state``, ``slipping``; see the leaf system.

    ``load`` [N] opposes positive motion. Error-controlled Runge-Kutta of order 3, stopping at every kink
    of the contact law.
    """
    builder = DiagramBuilder()
    plant = builder.AddSystem(StickSlipActuator(actuator, drive, direction))
    source = builder.AddSystem(ConstantVectorSource([load]))
    builder.Connect(source.get_output_port(), plant.GetInputPort("load"))
    for name in ("position", "state", "slipping"):
        builder.ExportOutput(plant.GetOutputPort(name), name)
    simulator = Simulator(builder.Build())
    simulator.get_mutable_context().SetAccuracy(ISOLATION)
    integrator = simulator.get_mutable_integrator()
    integrator.set_target_accuracy(ACCURACY)
    integrator.set_maximum_step_size(LONGEST_STEP)
    integrator.request_initial_step_size_target(0.1 * LONGEST_STEP)
    return simulator
