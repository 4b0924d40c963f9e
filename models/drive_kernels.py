"""Compiled loops over the laws of a drive: closed-loop simulation and stabilised prediction.

Both loops work sample by sample on arrays (samples, n) and call the plain functions of ``drive.py``
and ``control.py``; the LeafSystems and the tests call the same ones.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import compilation, control, drive, drive_stack, encoder, friction, runge_kutta, stack
from .drive import Drive

compilation.register_laws(friction, encoder, control, runge_kutta, drive)

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
    if np.any(controller.rate_from_state):
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


@compilation.kernel
def replay_controller(
    reference: Any,
    reference_acceleration: Any,
    position: Any,
    controller: LoopController,
    dt: float,
    memory: Any,
    command: Any,
) -> None:
    """Command (samples, n) that the controller computes from a measured position."""
    for k in range(position.shape[0]):
        control_step(
            k, reference, reference_acceleration, position, controller, dt, memory, command
        )


def simulate(
    reference: Any,
    reference_acceleration: Any,
    plant: Drive,
    controller: LoopController,
    dt: float,
    substeps: int,
    lsb: float,
    memory: Any,
    position: Any,
    command: Any,
    delivered: Any,
    first_sensed: int = 0,
) -> None:
    """Closed loop from rest at ``position[0]``: writes position, command, delivered (samples, n).

    ``lsb`` is the encoder's step, 0 for an exact one; ``position`` is what the encoder reads.
    ``delivered[k]`` is the mean torque at the shafts during sample ``k``. The motors drive the first n shafts of
    the plant; a flexible plant has more. The encoders sit on n shafts from ``first_sensed`` on.
    """
    closed_loop(
        reference, reference_acceleration, plant, drive_stack.sizes(plant), stack.axis(reference.shape[1]), controller, dt,
        substeps, lsb, memory, position, command, delivered, stack.axis(first_sensed),
    )  # fmt: skip


@compilation.kernel
def closed_loop(
    reference: Any,
    reference_acceleration: Any,
    given: Drive,
    sizes: drive_stack.Sizes,
    sensors: stack.Axis,
    controller: LoopController,
    dt: float,
    substeps: int,
    lsb: float,
    start: Any,
    position: Any,
    command: Any,
    delivered: Any,
    before: stack.Axis,
) -> None:
    """``simulate`` for sizes that the compiler knows, of floats or of lanes.

    ``start`` is the memory, ``before`` are the shafts before the first that has an encoder.
    """
    n, shafts = len(sensors), len(sizes.shafts)
    samples = position.shape[0]
    plant = drive_stack.plant_on_stack(given, sizes)
    memory = drive_stack.memory_on_stack(sensors, position)
    for j in range(n):
        memory[LOW_PASSED][j], memory[INTEGRAL][j] = start[LOW_PASSED, j], start[INTEGRAL, j]
        memory[OBSERVED][j] = start[OBSERVED, j]
    q, v, z, held, lag, torque, work = drive_stack.state_on_stack(sizes, sensors, position)
    for j in range(shafts):
        q[j] = position[0, j % n]
    for k in range(samples):
        for j in range(n):
            position[k, j] = encoder.read(q[len(before) + j], lsb)
        control_step(
            k, reference, reference_acceleration, position, controller, dt, memory, command
        )
        advance(k, q, v, z, held, lag, torque, command, plant, dt, substeps, work)
        for j in range(n):
            delivered[k, j] = torque[j]


def predict(
    position: Any,
    command: Any,
    plant: Drive,
    dt: float,
    substeps: int,
    bandwidth: float,
    residual: Any,
    first_sensed: int = 0,
) -> None:
    """One-sample-ahead prediction errors ``residual`` (samples, n) of the measured position.

    The model is driven by the logged command and corrected by its own error with a double pole at
    ``bandwidth`` [rad/s], a fixed-gain (alpha-beta) observer. Errors of a right model are as white as
    the encoder's noise, whatever the controller; low frequencies weigh more at a low bandwidth.
    The encoders sit on n shafts from ``first_sensed`` on. A shaft without an encoder is corrected with the one
    at the other end of its transmission.
    """
    sensors = stack.axis(position.shape[1])
    sizes = drive_stack.sizes(plant)
    prediction(
        position, command, plant, sizes, sensors, dt, substeps, bandwidth, residual,
        stack.axis(first_sensed),
    )  # fmt: skip


@compilation.kernel
def prediction(
    position: Any,
    command: Any,
    given: Drive,
    sizes: drive_stack.Sizes,
    sensors: stack.Axis,
    dt: float,
    substeps: int,
    bandwidth: float,
    residual: Any,
    before: stack.Axis,
) -> None:
    """``predict`` for sizes that the compiler knows, of floats or of lanes; ``before`` as in ``closed_loop``."""
    samples, n, shafts = position.shape[0], len(sensors), len(sizes.shafts)
    alpha, beta = correction_gains(bandwidth, dt)
    plant = drive_stack.plant_on_stack(given, sizes)
    q, v, z, held, lag, torque, work = drive_stack.state_on_stack(sizes, sensors, residual)
    for j in range(shafts):
        q[j] = position[0, j % n]
    for k in range(samples):
        for j in range(n):
            residual[k, j] = position[k, j] - q[len(before) + j]
        for j in range(shafts):
            q[j] += alpha * residual[k, j % n]
            v[j] += beta * residual[k, j % n]
        advance(k, q, v, z, held, lag, torque, command, plant, dt, substeps, work)


@compilation.part
def correction_gains(bandwidth: float, dt: float) -> tuple[float, float]:
    """Gains on position [-] and speed [1/s] of the double pole exp(-bandwidth dt)."""
    pole = np.exp(-bandwidth * dt)
    return 1.0 - pole * pole, (1.0 - pole) * (1.0 - pole) / dt


@compilation.kernel
def rest(plant: Drive, actuated: int) -> tuple[Any, ...]:
    """Speeds, bristle deflections, held forces, lag states of the ``actuated`` shafts and torques, at rest."""
    m, shafts = plant.elements.shape
    return np.zeros(shafts), np.zeros(m), np.zeros(m), np.zeros((2, actuated)), np.zeros(shafts)


@compilation.kernel
def move(
    q: Any,
    v: Any,
    z: Any,
    held: Any,
    torque: Any,
    t: float,
    plant: Drive,
    dt: float,
    substeps: int,
    work: Any,
) -> None:
    """Move positions, speeds and bristles on by one sample ``dt`` from ``t`` under held torques.

    The loops have these lines in place: a call of a kernel there costs them a third of their speed.
    """
    step = dt / substeps
    for part in range(substeps):
        drive.held_friction(v, z, step, plant, held)
        drive.ode4_step(q, v, held, torque, t + part * step, step, plant, work)


@compilation.kernel
def acceleration(
    q: Any, v: Any, held: Any, torque: Any, t: float, plant: Drive, work: Any, out: Any
) -> None:
    """``drive.acceleration`` for floats."""
    drive.acceleration(q, v, held, torque, t, plant, work, out)


@compilation.part
def advance(
    k: int,
    q: Any,
    v: Any,
    z: Any,
    held: Any,
    lag: Any,
    torque: Any,
    command: Any,
    plant: Drive,
    dt: float,
    substeps: int,
    work: Any,
) -> None:
    """Move the plant on by one sample under ``command`` (samples, n); notes the delivered torque."""
    drive.deliver_torques(k, command, lag, dt, plant, torque)
    step = dt / substeps
    for part in range(substeps):
        drive.held_friction(v, z, step, plant, held)
        drive.ode4_step(q, v, held, torque, k * dt + part * step, step, plant, work)
