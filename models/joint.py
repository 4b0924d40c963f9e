r"""What resists a joint beside the rigid-body dynamics, and what its actuator makes of a command.

1. resistance :math:`f = b v + (F_c + F_s e^{-(v/v_s)^2} + \mu|\tau| + \lambda|\ell|)\tanh(v/w) + k q + c`,
   positive against positive speed, with the motor's torque :math:`\tau` and the load :math:`\ell` of gravity;
2. actuator: the command is delayed, multiplied by a gain, limited and passed through a first-order
   lag, in this order.

The dry part is ``friction.dry``. Rotary joints use rad and N m, prismatic ones m and N. Not modelled
here: clearance and flexibility.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import friction

# Columns of ``Joints.law``, the constants of a joint.
(
    VISCOUS,  # [N m s/rad or N s/m]
    DRY,  # sliding level [N m or N]
    BREAKAWAY,  # dry friction at standstill beyond the sliding level [N m or N]
    STRIBECK_SPEED,  # [rad/s or m/s]
    WIDTH,  # smoothing of the sign [rad/s or m/s]
    BY_MOTOR,  # dry friction per magnitude of the motor's effort [-]
    BY_LOAD,  # dry friction per magnitude of the gravity load [-]
    SPRING,  # load per position, such as a cable's [N m/rad or N/m]
    BIAS,  # constant load [N m or N]
) = range(9)

# Columns of ``Joints.actuator``, the constants of an actuator.
(
    GAIN,  # effort delivered per effort commanded [-]
    DELAY,  # [s]
    LAG,  # time constant [s]
    LIMIT,  # largest effort [effort unit]
) = range(4)


class Joints(NamedTuple):
    """Constants of the joints and of their actuators."""

    law: NDArray[np.float64]  # (n, 9)
    actuator: NDArray[np.float64]  # (m, 4)


def ideal_joints(joints: int, actuators: int, width: float) -> Joints:
    """Frictionless joints with perfect actuators; ``width`` smooths signs once friction is added."""
    law = np.zeros((joints, 9))
    law[:, STRIBECK_SPEED] = 1.0
    law[:, WIDTH] = width
    actuator = np.zeros((actuators, 4))
    actuator[:, GAIN] = 1.0
    actuator[:, LIMIT] = np.inf
    return Joints(law, actuator)


def resistance(row: Any, q: Any, v: Any, motor: Any, load: Any) -> Any:
    """Effort (1) against positive motion of a joint with the constants ``row`` (9,)."""
    level = row[DRY] + row[BY_MOTOR] * np.abs(motor) + row[BY_LOAD] * np.abs(load)
    smooth = friction.viscous(v, row[VISCOUS]) + row[SPRING] * q + row[BIAS]
    if level == 0.0 and row[BREAKAWAY] == 0.0:
        return smooth
    return smooth + friction.dry(v, level, level, row[BREAKAWAY], row[STRIBECK_SPEED], row[WIDTH])


def held_command(commands: Any, time: Any, delay: Any, dt: Any, column: Any) -> Any:
    """What arrives at a time [s] of commands (S, m) that are held until the next sample."""
    index = int(np.floor((time - delay) / dt + 1e-9))
    return commands[max(index, 0), column]
