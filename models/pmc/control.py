r"""Controllers of the PepperMill-Carrier, one sample at a time, from motor angles to motor torques.

1. FEEDBACK           :math:`\tau = K_P e + K_D \dot e` in motor angles (4.32); with
   :math:`K = J^{-1}\,\mathrm{diag}(k^{trans}, k^{rot})\,J` per C-drive, the task-space PD (4.37) of
   Table 5-10;
2. COMPUTED_TORQUE    :math:`f = \hat M(w)(\ddot w_d + k_P e + k_D \dot e) + \hat c(w, \dot w)` in joints (4.33-4.34
   with the robot's own inertia, which the thesis did not have);
3. RESOLVED           the same with the error in the pose:
   :math:`\ddot x = \ddot x_d + K_P e_x + K_D \dot e_x`, then joint accelerations (section 4.6.3, and the
   recommendation of chapter 6).

:math:`\dot e` comes from the filter (5.1) for held samples, which reads a ramp too steep by
:math:`N T / (1 - e^{-N T})`, 33 % at the prototype's N; the joint rates of (2) and (3) leave that factor out. Motor order (L1, R1, L2, R2), angles from home.
"""

from typing import Any, NamedTuple

from .. import control
from . import displacement, dynamics
from .dynamics import Constants

FEEDBACK, COMPUTED_TORQUE, RESOLVED = range(3)


class Controller(NamedTuple):
    """A controller as arrays; unused gains are zero."""

    kind: int
    kp: Any  # (4, 4): of motor errors [N m/rad], joint errors or pose errors [1/s^2]
    kd: Any  # (4, 4): [N m s/rad] or [1/s]
    decay: float  # of the derivative filter per sample [-]
    cutoff: float  # N of the derivative filter [rad/s]
    rate_cutoff: float  # the same, so that a ramp's rate is exact at the sample times [rad/s]
    limit: float  # of the torques [N m]
    joint_map: Any  # (4, 4) joints per motor angles
    motor_map: Any  # (4, 4) its inverse
    home: Any  # (4,) joints at motor angles zero
    model: Constants  # the robot as the controller believes it to be


class Target(NamedTuple):
    """Reference of one sample."""

    joints: Any  # (4,)
    joint_acceleration: Any  # (4,)
    pose: Any  # (4,)
    pose_acceleration: Any  # (4,)


# Rows of a controller's memory (5, 4): two low-passed signals, then scratch.
ERROR_LOW, JOINT_LOW, JOINTS, ERROR, SLOPE = range(5)


def wake_up(psi: Any, controller: Controller, memory: Any) -> None:
    """Set the memory of a controller that starts at rest on its reference, motors at ``psi``."""
    for i in range(4):
        memory[ERROR_LOW, i] = 0.0
        memory[JOINT_LOW, i] = controller.home[i] + control.row(i, controller.joint_map, psi)


def step(target: Target, psi: Any, controller: Controller, memory: Any, torque: Any) -> None:
    """Write the motor torques (4,) for measured motor angles ``psi`` (4,); moves ``memory`` on."""
    c = controller
    for i in range(4):
        memory[JOINTS, i] = c.home[i] + control.row(i, c.joint_map, psi)
        memory[SLOPE, i] = target.joints[i] - c.home[i]
    _errors(target, psi, c, memory)
    for i in range(4):
        error, low = memory[ERROR, i], memory[ERROR_LOW, i]
        memory[SLOPE, i] = control.filtered_derivative(error, low, c.cutoff)
        memory[ERROR_LOW, i] = control.low_pass(error, low, c.decay)
    if c.kind == FEEDBACK:
        for i in range(4):
            torque[i] = control.row(i, c.kp, memory[ERROR]) + control.row(i, c.kd, memory[SLOPE])
    else:
        _model_based(target, c, memory, torque)
    for i in range(4):
        torque[i] = control.clip(torque[i], c.limit)


def _errors(target: Target, psi: Any, c: Controller, memory: Any) -> None:
    if c.kind == FEEDBACK:
        for i in range(4):
            memory[ERROR, i] = control.row(i, c.motor_map, memory[SLOPE]) - psi[i]
    elif c.kind == COMPUTED_TORQUE:
        for i in range(4):
            memory[ERROR, i] = target.joints[i] - memory[JOINTS, i]
    else:
        joints = memory[JOINTS]
        x, y, z, phi = displacement.pose(
            (joints[0], joints[1], joints[2], joints[3]), -1.0, -1.0, c.model.dimensions
        )
        memory[ERROR, 0], memory[ERROR, 1] = target.pose[0] - x, target.pose[1] - y
        memory[ERROR, 2], memory[ERROR, 3] = target.pose[2] - z, target.pose[3] - phi


def _model_based(target: Target, c: Controller, memory: Any, torque: Any) -> None:
    """Laws (2) and (3); overwrites the rows ERROR and SLOPE with the asked accelerations and rates."""
    desired = target.joint_acceleration if c.kind == COMPUTED_TORQUE else target.pose_acceleration
    for i in range(4):
        torque[i] = (
            desired[i] + control.row(i, c.kp, memory[ERROR]) + control.row(i, c.kd, memory[SLOPE])
        )
    for i in range(4):
        joint, low = memory[JOINTS, i], memory[JOINT_LOW, i]
        memory[SLOPE, i] = control.filtered_derivative(joint, low, c.rate_cutoff)
        memory[JOINT_LOW, i] = control.low_pass(joint, low, c.decay)
    q, v = memory[JOINTS], memory[SLOPE]
    joints, rates = (q[0], q[1], q[2], q[3]), (v[0], v[1], v[2], v[3])
    asked = (torque[0], torque[1], torque[2], torque[3])
    if c.kind == RESOLVED:
        asked = displacement.joint_acceleration(joints, rates, asked, c.model.dimensions)
    force = dynamics.inverse_dynamics(joints, rates, asked, c.model)
    for i in range(4):
        torque[i] = (
            c.joint_map[0, i] * force[0]
            + c.joint_map[1, i] * force[1]
            + c.joint_map[2, i] * force[2]
            + c.joint_map[3, i] * force[3]
        )
