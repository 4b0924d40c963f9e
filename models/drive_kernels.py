"""Compiled loops over the laws of a drive: closed-loop simulation and stabilised prediction.

Both loops work sample by sample on arrays (samples, n) and call the plain functions of ``drive.py``
and ``control.py``; the LeafSystems and the tests call the same ones.
"""

from typing import Any

import numpy as np

from . import compilation, control, drive, drive_stack, encoder, friction, runge_kutta, stack
from .drive import Drive
from .drive_stack import has_rare_effects
from .sampled_controller import (
    CASCADE as CASCADE,
)
from .sampled_controller import (
    FEEDBACK as FEEDBACK,
)
from .sampled_controller import (
    INTEGRAL,
    LOW_PASSED,
    OBSERVED,
    LoopController,
    control_step,
    controller_on_stack,
    memory_on_stack,
)
from .sampled_controller import (
    initial_memory as initial_memory,
)

compilation.register_laws(friction, encoder, control, runge_kutta, drive)


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
    sizes = drive_stack.sizes(plant, has_rare_effects(plant.element, plant.shaft))
    closed_loop(
        reference, reference_acceleration, plant, sizes, stack.axis(reference.shape[1]), controller, dt,
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
    law = controller_on_stack(controller, sensors)
    wanted, wanted_acceleration = stack.borrowed(reference), stack.borrowed(reference_acceleration)
    read, commanded = stack.borrowed(position), stack.borrowed(command)
    memory = memory_on_stack(sensors, position)
    for j in range(n):
        memory[LOW_PASSED][j], memory[INTEGRAL][j] = start[LOW_PASSED, j], start[INTEGRAL, j]
        memory[OBSERVED][j] = start[OBSERVED, j]
    q, v, z, held, lag, torque, work = drive_stack.state_on_stack(sizes, sensors, position)
    for j in range(shafts):
        q[j] = position[0, j % n]
    for k in range(samples):
        for j in range(n):
            read[k, j] = encoder.read(q[len(before) + j], lsb)
        control_step(k, wanted, wanted_acceleration, read, law, dt, memory, commanded)
        advance(k, q, v, z, held, lag, torque, commanded, plant, dt, substeps, work)
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
    measured, commanded = stack.borrowed(position), stack.borrowed(command)
    q, v, z, held, lag, torque, work = drive_stack.state_on_stack(sizes, sensors, residual)
    for j in range(shafts):
        q[j] = position[0, j % n]
    for k in range(samples):
        for j in range(n):
            residual[k, j] = measured[k, j] - q[len(before) + j]
        for j in range(shafts):
            q[j] += alpha * residual[k, j % n]
            v[j] += beta * residual[k, j % n]
        advance(k, q, v, z, held, lag, torque, commanded, plant, dt, substeps, work)


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
