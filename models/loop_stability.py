"""Stability of a sampled loop: eigenvalues of its exact map from one sample to the next.

The map is that of ``drive_kernels``: encoder without quantisation, ``control_step``, delay and lag of
the actuator, Runge-Kutta steps of the plant. The loop is linear, so its matrix is what the map
makes of the unit vectors; no second set of equations is written down. Hold, derivative filter, observer,
computational delay and amplifier lag are all in it. Not in it: quantisation, dry friction,
clearance and torque limits, which bound or excite an oscillation but are not linear.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import compilation, drive
from .drive import Drive
from .drive_kernels import advance
from .sampled_controller import (
    FEEDBACK,
    INTEGRAL,
    LOW_PASSED,
    OBSERVED,
    ROWS,
    LoopController,
    control_step,
)

# The amplifier's torque limit does not matter to small motions; everything else must be linear.
NONLINEAR_ELEMENT = {
    "VISCOUS_SKEW": drive.VISCOUS_SKEW,
    "FORWARD": drive.FORWARD,
    "BACKWARD": drive.BACKWARD,
    "BREAKAWAY": drive.BREAKAWAY,
    "STIFFNESS": drive.STIFFNESS,
    "FADE": drive.FADE,
}
NONLINEAR_SHAFT = {
    "LOAD_FRICTION": drive.LOAD_FRICTION,
    "NET_LOAD_FRICTION": drive.NET_LOAD_FRICTION,
    "BIAS": drive.BIAS,
    "RIPPLE_COS": drive.RIPPLE_COS,
    "RIPPLE_SIN": drive.RIPPLE_SIN,
}


class Mode(NamedTuple):
    """The least damped mode of a sampled loop."""

    radius: float  # magnitude of its eigenvalue per sample; the loop is stable below 1 [-]
    growth: float  # of its amplitude [1/s]
    frequency: float  # [Hz]


def loop_matrix(
    plant: Drive, controller: LoopController, dt: float, substeps: int = 1
) -> NDArray[np.float64]:
    """Matrix of the map over one sample of ``dt`` seconds, reference zero.

    State: positions and speeds of all shafts, low-passed error, observer, integral of the error (if
    the controller has one), lag of the actuators, past commands. Raises ValueError for a plant
    that is not linear or a controller other than FEEDBACK.
    """
    _check_linear(plant, controller)
    shafts, n = plant.shaft.shape[0], controller.kp.shape[0]
    past = int(np.max(plant.shaft[:, drive.DELAY]) // dt) + 1
    size = 2 * shafts + (5 + past) * n
    matrix = np.zeros((size, size))
    _probe(plant, controller, dt, substeps, past, np.eye(size), matrix)
    if not np.any(controller.ki):
        keep = np.r_[0 : 2 * shafts + 2 * n, 2 * shafts + 3 * n : size]
        return matrix[np.ix_(keep, keep)]
    return matrix


def dominant_mode(plant: Drive, controller: LoopController, dt: float, substeps: int = 1) -> Mode:
    """The mode that decides whether the loop is stable; errors as for ``loop_matrix``."""
    values = np.linalg.eigvals(loop_matrix(plant, controller, dt, substeps))
    worst = values[np.argmax(np.abs(values))]
    radius = float(np.abs(worst))
    return Mode(radius, float(np.log(radius) / dt), float(abs(np.angle(worst)) / (2 * np.pi * dt)))


@compilation.kernel
def _probe(
    plant: Drive,
    controller: LoopController,
    dt: float,
    substeps: int,
    past: int,
    states: Any,
    after: Any,
) -> None:
    """Column i of ``after`` is the state one sample after the state in row i of ``states``."""
    shafts, n = plant.shaft.shape[0], controller.kp.shape[0]
    m = plant.elements.shape[0]
    zero = np.zeros((past + 1, n))
    z, held, torque, lag = np.zeros(m), np.zeros(m), np.zeros(shafts), np.zeros((2, n))
    work = drive.work_arrays(shafts)
    for i in range(states.shape[0]):
        x = states[i]
        q, v = x[:shafts].copy(), x[shafts : 2 * shafts].copy()
        rest = x[2 * shafts :].copy().reshape((5 + past, n))
        memory = np.zeros((ROWS, n))
        memory[LOW_PASSED], memory[OBSERVED], memory[INTEGRAL] = rest[0], rest[1], rest[2]
        position, command = np.zeros((past + 1, n)), np.zeros((past + 1, n))
        command[:past] = rest[5:]
        position[past] = q[:n]
        lag[:, :n] = rest[3:5]
        control_step(past, zero, zero, position, controller, dt, memory, command)
        advance(past, q, v, z, held, lag, torque, command, plant, dt, substeps, work)
        rest[0], rest[1], rest[2] = memory[LOW_PASSED], memory[OBSERVED], memory[INTEGRAL]
        rest[3:5] = lag[:, :n]
        rest[5:] = command[1:]
        after[:shafts, i], after[shafts : 2 * shafts, i] = q, v
        after[2 * shafts :, i] = rest.copy().reshape((5 + past) * n)


def _check_linear(plant: Drive, controller: LoopController) -> None:
    if controller.kind != FEEDBACK:
        raise ValueError("the controller is a cascade; expected a FEEDBACK controller")
    for table, columns in ((plant.element, NONLINEAR_ELEMENT), (plant.shaft, NONLINEAR_SHAFT)):
        for name, column in columns.items():
            if np.any(table[:, column] != 0.0):
                raise ValueError(f"{name} of the drive is not zero; expected a linear drive")
    if np.any(plant.coupling[:, drive.GAP] != 0.0):
        raise ValueError("GAP of a coupling is not zero; expected a linear drive")
