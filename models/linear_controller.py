r"""A sampled controller without limits as a linear system, by probing its own step.

.. math:: x_{k+1} = A x_k + B u_k, \quad y_k = C x_k + D u_k

The input is the reference (n,), its acceleration (n,) and the measured position (n,); the output is the command (n,). The
state is the low-passed error, the integral of the error, the observer's state and the last command, (4 n,).
``sampled_controller.control_step`` is linear in them, so that its values at unit vectors are the columns of the matrices.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .sampled_controller import (
    FEEDBACK,
    INTEGRAL,
    LOW_PASSED,
    OBSERVED,
    ROWS,
    LoopController,
    control_step,
)

Floats = NDArray[np.float64]
INPUTS, STATES = 3, 4  # of each shaft


class LinearController(NamedTuple):
    """The four matrices of a sampled linear system."""

    a: Floats  # (4 n, 4 n)
    b: Floats  # (4 n, 3 n)
    c: Floats  # (n, 4 n)
    d: Floats  # (n, 3 n)


def linear_controller(controller: LoopController, dt: float) -> LinearController:
    """The matrices of a FEEDBACK controller of n shafts, sampled every ``dt`` seconds.

    Raises ValueError for a cascade or a controller that limits its command.
    """
    if controller.kind != FEEDBACK:
        raise ValueError("the controller is a cascade; expected a FEEDBACK controller")
    if controller.limit < np.inf:
        raise ValueError(
            f"the controller limits its command to {controller.limit:g}; expected no limit"
        )
    n = len(controller.kp)
    size = STATES * n
    units = np.eye(size + INPUTS * n)
    columns = [_step(controller, dt, unit[:size], unit[size:]) for unit in units]
    after, command = (np.array(part).T for part in zip(*columns))
    return LinearController(after[:, :size], after[:, size:], command[:, :size], command[:, size:])


def _step(controller: LoopController, dt: float, state: Floats, inputs: Floats) -> Any:
    """The next state and the command."""
    reference, acceleration, position = (np.tile(row, (2, 1)) for row in np.split(inputs, INPUTS))
    memory = np.zeros((ROWS, len(controller.kp)))
    memory[LOW_PASSED], memory[INTEGRAL], memory[OBSERVED], last = np.split(state, STATES)
    command = np.array([last, np.zeros_like(last)])
    step = getattr(control_step, "py_func", control_step)  # as plain Python
    step(1, reference, acceleration, position, controller, dt, memory, command)
    after = [memory[LOW_PASSED], memory[INTEGRAL], memory[OBSERVED], command[1]]
    return np.concatenate(after), command[1]
