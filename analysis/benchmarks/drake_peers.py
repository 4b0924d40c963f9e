"""The closed loop in Drake without gapscope: plain-Python leaves, and Drake's own C++ systems."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import peer_laws as laws
from .peer_laws import Constants

Signals = tuple[NDArray[np.float64], NDArray[np.float64]]


def python_leaves(c: Constants, reference: NDArray[np.float64]) -> Callable[[], Signals]:
    """Source, controller, plant and encoder as LeafSystems whose laws are plain Python."""
    from pydrake.systems.framework import DiagramBuilder

    from .drake_leaves import EncoderLeaf, PDLeaf, PlantLeaf, SourceLeaf

    builder = DiagramBuilder()
    source, controller = builder.AddSystem(SourceLeaf(c, reference)), builder.AddSystem(PDLeaf(c))
    plant, encoder = builder.AddSystem(PlantLeaf(c)), builder.AddSystem(EncoderLeaf(c))
    builder.Connect(source.get_output_port(), controller.GetInputPort("reference"))
    builder.Connect(encoder.get_output_port(), controller.GetInputPort("measured"))
    builder.Connect(controller.get_output_port(), plant.get_input_port())
    builder.Connect(plant.get_output_port(), encoder.get_input_port())
    ports = [encoder.get_output_port(), controller.get_output_port()]
    return logged(builder, ports, c.dt, len(reference))


def primitives(c: Constants, reference: NDArray[np.float64]) -> Callable[[], Signals]:
    """TrajectorySource, Multiplexers and SymbolicVectorSystems: Python wires, C++ computes.

    Each stage of ODE4 is one system: expanded into one, its nested tanh would be thousands of terms.
    """
    from pydrake.symbolic import floor, tanh
    from pydrake.systems.framework import DiagramBuilder

    builder = DiagramBuilder()
    x, q, r, y, low = _variables("xqryl", (4, 2, 2, 2, 2))
    slopes = _variables("abcd", (2, 2, 2, 2))
    source = builder.AddSystem(_held(reference, c.dt))
    read = [c.lsb * floor(angle / c.lsb + 0.5) for angle in x[:2]] if c.lsb > 0.0 else x[:2]
    encoder = _symbolic(builder, c, x, read)
    error = laws.difference(r, y)
    controller = _symbolic(
        builder, c, [*r, *y], laws.pd(c, error, low), low, laws.low_pass(c, error, low)
    )
    _join(builder, controller, source, encoder)
    step = laws.ode4_sum(c, x, slopes)
    plant = _symbolic(builder, c, [slope for stage in slopes for slope in stage], x, x, step)
    builder.Connect(plant.get_output_port(), encoder.get_input_port())
    stages: list[Any] = []
    for part in (0.0, 0.5, 0.5, 1.0):
        before, inputs = (q, [*x, *y, *q]) if stages else ([0.0, 0.0], [*x, *y])
        speed = laws.ahead(c, x[2:], before, part)
        stage = _symbolic(builder, c, inputs, laws.acceleration(c, speed, y, tanh))
        _join(builder, stage, plant, controller, *stages[-1:])
        stages.append(stage)
    _join(builder, plant, *stages)
    ports = [encoder.get_output_port(), controller.get_output_port()]
    return logged(builder, ports, c.dt, len(reference))


def _variables(names: str, sizes: tuple[int, ...]) -> list[list[Any]]:
    from pydrake.symbolic import Variable

    return [[Variable(f"{name}{j}") for j in range(n)] for name, n in zip(names, sizes)]


def _symbolic(
    builder: Any, c: Constants, inputs: Any, output: Any, state: Any = (), dynamics: Any = ()
) -> Any:
    from pydrake.systems.primitives import SymbolicVectorSystem

    system = SymbolicVectorSystem(
        state=np.array(state, dtype=object),
        input=np.array(inputs, dtype=object),
        dynamics=np.array([0.0 + slope for slope in dynamics], dtype=object),
        output=np.array([0.0 + value for value in output], dtype=object),
        time_period=c.dt if len(state) else 0.0,
    )
    return builder.AddSystem(system)


def _held(reference: NDArray[np.float64], dt: float) -> Any:
    """Samples held from half a sample before: a clock early by a rounding still finds its own."""
    from pydrake.systems.primitives import TrajectorySource
    from pydrake.trajectories import PiecewisePolynomial

    breaks = dt * (np.arange(len(reference) + 1) - 0.5)
    samples = np.vstack([reference, reference[-1:]]).T
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(breaks, samples))


def _join(builder: Any, target: Any, *sources: Any) -> None:
    from pydrake.systems.primitives import Multiplexer

    sizes = [source.get_output_port().size() for source in sources]
    joined = builder.AddSystem(Multiplexer(sizes))
    for j, source in enumerate(sources):
        builder.Connect(source.get_output_port(), joined.get_input_port(j))
    builder.Connect(joined.get_output_port(), target.get_input_port())


def logged(builder: Any, ports: Sequence[Any], dt: float, samples: int) -> Callable[[], Signals]:
    """One simulation of the diagram in ``builder``, built beforehand, with logs (samples, 2) of two output ports."""
    from pydrake.systems.analysis import Simulator
    from pydrake.systems.primitives import VectorLogSink

    sinks: list[Any] = []
    for port in ports:
        sinks.append(builder.AddSystem(VectorLogSink(2, publish_period=dt)))
        builder.Connect(port, sinks[-1].get_input_port())
    diagram = builder.Build()

    def run() -> Signals:
        simulator = Simulator(diagram)
        simulator.AdvanceTo(dt * (samples - 1))
        context = simulator.get_context()
        measured, command = (np.array(sink.FindLog(context).data().T) for sink in sinks)
        return measured, command

    return run
