"""A sampled controller as a compiled loop has it: arrays of settings, a memory, and one step.

The laws are those of ``control.py``; LeafSystems and tests call the same ones.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import compilation, control, stack

compilation.register_laws(control)

FEEDBACK = 0
CASCADE = 1


class LoopController(NamedTuple):
    """A sampled controller as arrays, so that one kernel serves them all.

    ``kind`` FEEDBACK: command = A (f r'' + Kp e + Ki int(e) + Kd D(e)) + F rate, with the observer's
    rate; PD and task-space PD have A = 1, f = F = 0, computed torque A = M, f = 1, F = c D.
    ``kind`` CASCADE: the cascade P-P law with ``kp[0, 0]``, ``kv`` and the mean-difference rate.
    """

    kind: int
    kp: Any  # (n, n) Kp
    ki: Any  # (n, n) Ki
    kd: Any  # (n, n) Kd
    cutoff: float  # N of the derivative filter [rad/s]
    output: Any  # (n, n) A
    feedforward: float  # f [-]
    friction: Any  # (n, n) F
    transition: Any  # (n, n) observer, see observer.DiscreteObserver
    from_position: Any
    from_torque: Any
    rate_from_state: Any
    rate_from_position: Any
    kv: float  # velocity gain of the cascade
    limit: float  # of the command [unit of the command]


# Rows of a controller's memory (8, n); the last five are scratch.
LOW_PASSED, INTEGRAL, OBSERVED, ERROR, SLOPE, RATE, SERVO, READING = range(ROWS := 8)


def initial_memory(controller: LoopController, position: Any) -> NDArray[np.float64]:
    """Memory (8, n) of a controller that wakes up at ``position`` (n,), the machine at rest."""
    memory = np.zeros((ROWS, len(position)))
    if controller.rate_from_state.any():
        memory[OBSERVED] = -np.linalg.solve(
            controller.rate_from_state, controller.rate_from_position @ np.asarray(position)
        )
    return memory


@compilation.part
def control_step(
    k: int,
    reference: Any,
    reference_acceleration: Any,
    position: Any,
    controller: LoopController,
    dt: float,
    memory: Any,
    command: Any,
) -> None:
    """Write ``command[k]`` (n,) from the samples (samples, n) up to ``k``; moves ``memory`` on."""
    low, integral, observed, error, slope, rates, servo, reading = memory
    n = low.size
    c = controller
    if c.kind == CASCADE:
        for j in range(n):
            rate = (position[k, j] - position[max(k - 2, 0), j]) / (2.0 * dt)
            value = control.cascade_p_p(reference[k, j], position[k, j], rate, c.kp[j, j], c.kv)
            command[k, j] = control.clip(value, c.limit)
        return
    decay = control.derivative_decay(c.cutoff, dt)
    for j in range(n):
        reading[j] = position[k, j]
        error[j] = reference[k, j] - reading[j]
        slope[j] = control.filtered_derivative(error[j], low[j], c.cutoff)
        low[j] = control.low_pass(error[j], low[j], decay)
    for i in range(n):
        rates[i] = control.observed_rate(
            i, c.rate_from_state, c.rate_from_position, observed, reading
        )
        servo[i] = c.feedforward * reference_acceleration[k, i] + control.pid(
            i, c.kp, c.ki, c.kd, error, integral, slope
        )
    for i in range(n):
        value = control.inverse_dynamics(i, c.output, c.friction, servo, rates)
        command[k, i] = control.clip(value, c.limit)
        integral[i] += dt * error[i]
    for i in range(n):  # the observer sees the torque of one sample ago, Fig. 4-2
        rates[i] = command[k - 1, i] if k > 0 else 0.0
    for i in range(n):
        slope[i] = control.observer_next(
            i, c.transition, c.from_position, c.from_torque, observed, reading, rates
        )
    for i in range(n):
        observed[i] = slope[i]


@compilation.inlined
def controller_on_stack(given: LoopController, sensors: stack.Axis) -> LoopController:
    """The controller with its matrices on the stack."""
    c = LoopController(
        given.kind,
        stack.matrix(sensors, sensors, given.kp),
        stack.matrix(sensors, sensors, given.ki),
        stack.matrix(sensors, sensors, given.kd),
        given.cutoff,
        stack.matrix(sensors, sensors, given.output),
        given.feedforward,
        stack.matrix(sensors, sensors, given.friction),
        stack.matrix(sensors, sensors, given.transition),
        stack.matrix(sensors, sensors, given.from_position),
        stack.matrix(sensors, sensors, given.from_torque),
        stack.matrix(sensors, sensors, given.rate_from_state),
        stack.matrix(sensors, sensors, given.rate_from_position),
        given.kv,
        given.limit,
    )
    stack.copy(given.kp, c.kp)
    stack.copy(given.ki, c.ki)
    stack.copy(given.kd, c.kd)
    stack.copy(given.output, c.output)
    stack.copy(given.friction, c.friction)
    stack.copy(given.transition, c.transition)
    stack.copy(given.from_position, c.from_position)
    stack.copy(given.from_torque, c.from_torque)
    stack.copy(given.rate_from_state, c.rate_from_state)
    stack.copy(given.rate_from_position, c.rate_from_position)
    return c


@compilation.inlined
def memory_on_stack(sensors: stack.Axis, like: Any) -> tuple[Any, ...]:
    """The eight rows of a controller's memory on the stack, zero."""
    return (
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
        stack.vector(sensors, like),
    )
