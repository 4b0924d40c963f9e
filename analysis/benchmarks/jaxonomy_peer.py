"""The closed loop in jaxonomy: LeafSystems whose laws it traces, compiled as a whole by JAX.

Raises ImportError where it is not installed.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import peer_laws as laws
from .other_peers import Run, Signals
from .peer_laws import Constants


def jaxonomy(c: Constants, reference: NDArray[np.float64]) -> Run:
    """Source, controller and plant with its encoder, all sampled, the plant's next state by ODE4."""
    import jax
    import jaxonomy as engine

    jax.config.update("jax_enable_x64", True)
    samples = len(reference)
    builder = engine.DiagramBuilder()
    source, controller, plant = builder.add(
        _source(c, reference, engine), _controller(c, engine), _plant(c, engine)
    )
    builder.connect(source.output_ports[0], controller.input_ports[0])
    builder.connect(plant.output_ports[0], controller.input_ports[1])
    builder.connect(controller.output_ports[0], plant.input_ports[0])
    diagram = builder.build()
    context = diagram.create_context()
    recorded = {"measured": plant.output_ports[0], "command": controller.output_ports[0]}
    options = engine.SimulatorOptions(max_major_steps=2 * samples + 10)

    def run() -> Signals:
        span = (0.0, c.dt * (samples - 1))
        results = engine.simulate(
            diagram, context, span, options=options, recorded_signals=recorded
        )
        measured, command = (np.asarray(results.outputs[name]) for name in recorded)
        return measured, command

    return run


def _nothing_but(ticket: Any) -> dict[str, Any]:
    return {"requires_inputs": False, "prerequisites_of_calc": [ticket]}


def _source(c: Constants, reference: NDArray[np.float64], engine: Any) -> Any:
    import jax.numpy as jnp
    from jaxonomy.framework import DependencyTicket

    table = jnp.asarray(reference)

    def at(time: Any, state: Any, *inputs: Any, **parameters: Any) -> Any:
        k = jnp.round(time / c.dt).astype(int)
        return table[jnp.clip(k, 0, len(reference) - 1)]

    system = engine.LeafSystem(name="source")
    system.declare_output_port(
        at, period=c.dt, default_value=table[0], **_nothing_but(DependencyTicket.time)
    )
    return system


def _controller(c: Constants, engine: Any) -> Any:
    import jax.numpy as jnp
    from jaxonomy.framework import DependencyTicket

    def command(time: Any, state: Any, wanted: Any, read: Any, **parameters: Any) -> Any:
        return jnp.stack(laws.pd(c, wanted - read, state.discrete_state))

    def update(time: Any, state: Any, wanted: Any, read: Any, **parameters: Any) -> Any:
        return jnp.stack(laws.low_pass(c, wanted - read, state.discrete_state))

    system = engine.LeafSystem(name="controller")
    for name in ("reference", "measured"):
        system.declare_input_port(name=name)
    system.declare_discrete_state(default_value=jnp.zeros(2))
    system.declare_periodic_update(update, period=c.dt, offset=0.0)
    system.declare_output_port(
        command,
        period=c.dt,
        default_value=jnp.zeros(2),
        prerequisites_of_calc=[DependencyTicket.xd, DependencyTicket.u],
    )
    return system


def _plant(c: Constants, engine: Any) -> Any:
    import jax.numpy as jnp
    from jaxonomy.framework import DependencyTicket

    def read(time: Any, state: Any, *inputs: Any, **parameters: Any) -> Any:
        angle = state.discrete_state[:2]
        return c.lsb * jnp.floor(angle / c.lsb + 0.5) if c.lsb > 0.0 else angle

    def update(time: Any, state: Any, torque: Any, **parameters: Any) -> Any:
        return jnp.stack(laws.ode4_step(c, state.discrete_state, torque, jnp.tanh))

    system = engine.LeafSystem(name="plant")
    system.declare_input_port(name="torque")
    system.declare_discrete_state(default_value=jnp.zeros(4))
    system.declare_periodic_update(update, period=c.dt, offset=0.0)
    system.declare_output_port(
        read, period=c.dt, default_value=jnp.zeros(2), **_nothing_but(DependencyTicket.xd)
    )
    return system
