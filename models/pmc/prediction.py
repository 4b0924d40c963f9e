r"""Predicting the encoders of the PepperMill-Carrier one sample ahead, compiled.

The closed-form dynamics run on the logged motor torques and are corrected by their own error with a fixed-gain
observer, as ``drive_kernels.predict`` does for drives of constant inertia. Between torque and robot stand the actuator and
friction laws of ``models.drive``, in motor coordinates:

1. :math:`M(w)\ddot w + c(w, \dot w) = T^T (\tau - E^T f(E \dot\psi) - h(\psi))`, :math:`\psi = T (w - w_0)`
2. with a coupling in the drive angles (bending of collar and link, clearance at the drive), the drive sides
   :math:`\theta_m` (2,) of inertia :math:`I_m` move on their own: :math:`I_m \ddot\theta_m = (T^T \ldots)_\theta - s`,
   and the torques s of the coupling take their place in (1).

3. dry friction of elbows and wrists, :math:`F \tanh` of the rates :math:`\dot\beta - \dot\alpha` and
   :math:`\dot\beta` of a limb.

States are (d1, d2, theta1, theta2, theta_m1, theta_m2); the last two repeat theta where there is no coupling.
Friction elements are the four motors (L1, R1, L2, R2) and the nuts of both C-drives, the
difference of their motors' speeds, eq. (2.6).
"""

import sys
from typing import Any, NamedTuple

import numpy as np

from .. import compilation, drive, encoder, friction, runge_kutta
from .. import control as drive_control
from .. import drive_kernels as kernels
from ..drive import Drive
from . import constants, control, displacement, dynamics, limb, simulation
from .control import Controller, Target
from .dynamics import Constants
from .parameters import PMCParameters

compilation.register_laws(
    friction,
    encoder,
    runge_kutta,
    drive,
    drive_control,
    limb,
    displacement,
    dynamics,
    control,
    simulation,
)

MOTORS = ("L1", "R1", "L2", "R2")
ELEMENTS = (*MOTORS, "nut1", "nut2")
STATES = 6


class Carrier(NamedTuple):
    """Constants of one robot behind its actuators, as arrays."""

    constants: Constants  # without the friction of the C-drives, which is in ``drive``
    drive: Drive  # actuators (4), friction elements (6) and couplings of theta1, theta2 (2 or none)
    joint_map: Any  # (4, 4) joints per motor angles
    motor_map: Any  # (4, 4) its inverse
    home: Any  # (4,) joints at motor angles zero
    drive_inertia: float  # I_m of each drive side [kg m^2], with a coupling only
    passive_dry: Any  # (3,) dry friction of elbows and wrists [N m], width of its sign [rad/s]


def carrier(parameters: PMCParameters, home: Any) -> Carrier:
    """The nominal robot: viscous friction of the C-drives in its elements, ideal actuators."""
    p, lead = parameters.drive, parameters.drive.lead
    nut = np.array([1.0, -1.0])
    elements = np.vstack([np.eye(4), np.kron(np.eye(2), nut)])
    viscous = [p.beta] * 4 + [0.5 * p.gamma] * 2
    law = drive.ideal_drive(np.eye(4), elements, viscous, p.sign_width)
    law.element[:, [drive.FORWARD, drive.BACKWARD]] = np.array([p.delta] * 4 + [p.eta] * 2)[:, None]
    bare = constants.of(parameters)._replace(
        motor_viscous=0.0, collar_viscous=0.0, motor_dry=0.0, collar_dry=0.0
    )
    return Carrier(
        bare,
        law,
        constants.joint_map(lead),
        constants.motor_map(lead),
        np.array(home, dtype=float),
        2.0 * parameters.rotor_inertia + parameters.collar_end_inertia,
        np.array([0.0, 0.0, 1.0]),
    )


class State(NamedTuple):
    """State and scratch of one prediction, arrays."""

    w: Any  # (6,) joints and drive sides [m, rad]
    v: Any  # (6,) their rates
    bristles: Any  # (6,) deflections of the friction elements [rad]
    held: Any  # (6,) their forces [N m]
    lag: Any  # (2, 4) states of the actuators [N m]
    torque: Any  # (4,) delivered [N m]
    stages: Any  # (5, 6) of the Runge-Kutta step
    motor: Any  # (3, 4) angles, speeds and net torques of the motors


def accelerations(
    w: Any, v: Any, held: Any, torque: Any, t: float, plant: Carrier, motor: Any, out: Any
) -> None:
    """Accelerations ``out`` (6,) of joints and drive sides, laws (1) and (2), as ``runge_kutta`` asks for them."""
    angle, speed, net = motor
    for i in range(4):
        angle[i] = speed[i] = 0.0
        for j in range(4):
            side = j if j < 2 else j + 2
            angle[i] += plant.motor_map[i, j] * (w[side] - plant.home[j])
            speed[i] += plant.motor_map[i, j] * v[side]
    drive.net_torque(angle, speed, held, torque, t, plant.drive, net)
    f1, f2, t1, t2 = simulation.joint_forces(net, plant.motor_map)
    if plant.passive_dry[0] + plant.passive_dry[1] > 0.0:
        # Limb 1 reaches along d2; limb 2 along d1, and counts its angle from the vertical.
        on_reach, on_angle = passive_friction(w[1], w[2], v[1], v[2], plant)
        f2, r1 = f2 - on_reach, on_angle
        on_reach, on_angle = passive_friction(w[0], 0.5 * np.pi - w[3], v[0], -v[3], plant)
        f1, r2 = f1 - on_reach, -on_angle
    else:
        r1 = r2 = 0.0
    if plant.drive.coupling.shape[0] > 0:
        s1, s2 = coupling(0, w, v, plant.drive), coupling(1, w, v, plant.drive)
        out[4], out[5] = (t1 - s1) / plant.drive_inertia, (t2 - s2) / plant.drive_inertia
        t1, t2 = s1, s2
    t1, t2 = t1 - r1, t2 - r2
    out[0], out[1], out[2], out[3] = dynamics.acceleration(
        (w[0], w[1], w[2], w[3]), (v[0], v[1], v[2], v[3]), (f1, f2, t1, t2), plant.constants
    )
    if plant.drive.coupling.shape[0] == 0:
        out[4], out[5] = out[2], out[3]


def passive_friction(h: Any, alpha: Any, h_rate: Any, alpha_rate: Any, plant: Carrier) -> Any:
    """Law (3): what the dry friction of one limb takes from its reach [N] and elevation [N m]."""
    dim = plant.constants.dimensions
    m = limb.motion(h, alpha, h_rate, alpha_rate, dim.proximal, dim.distal)
    elbow, wrist, width = plant.passive_dry
    bent = elbow * friction.smooth_sign(m.beta_rate - alpha_rate, width)
    both = bent + wrist * friction.smooth_sign(m.beta_rate, width)
    return m.beta_by_h * both, m.beta_by_alpha * both - bent


def coupling(i: int, w: Any, v: Any, law: Drive) -> Any:
    """Torque [N m] from the drive side of limb ``i`` (0 or 1) on its link."""
    return drive.coupling_force(
        w[4 + i] - w[2 + i],
        v[4 + i] - v[2 + i],
        law.coupling[i, drive.COUPLING_STIFFNESS],
        law.coupling[i, drive.COUPLING_DAMPING],
        law.coupling[i, drive.GAP],
    )


def first_gains(k: int, dt: float) -> tuple[float, float]:
    """Gains on position [-] and speed [1/s] of the least-squares line through the first k + 1 samples."""
    n = k + 1.0
    return 2.0 * (2.0 * n - 1.0) / (n * (n + 1.0)), (6.0 / (n * (n + 1.0)) / dt if k > 0 else 0.0)


compilation.register_laws(sys.modules[__name__])


@compilation.kernel
def predict(
    position: Any,
    command: Any,
    plant: Carrier,
    dt: float,
    substeps: int,
    bandwidth: float,
    residual: Any,
) -> None:
    """Prediction errors ``residual`` (samples, 4) of the motor angles ``position`` under ``command``.

    The double pole of the correction comes down to ``bandwidth`` [rad/s] as the first samples tell how fast the
    robot moves. NaN from where the model leaves its branch.
    """
    least = kernels.correction_gains(bandwidth, dt)
    state = _at_rest(position[0], command[0], plant)
    for k in range(position.shape[0]):
        first = first_gains(k, dt)
        alpha, beta = max(first[0], least[0]), max(first[1], least[1])
        _motor_angles(state.w, plant, residual[k])
        for j in range(4):
            residual[k, j] = position[k, j] - residual[k, j]
        for i in range(4):
            error = drive_control.row(i, plant.joint_map, residual[k])
            state.w[i] += alpha * error
            state.v[i] += beta * error
            if i > 1:
                state.w[i + 2] += alpha * error
                state.v[i + 2] += beta * error
        _advance(k, state, command, plant, dt, substeps)


@compilation.kernel
def simulate(
    joints: Any,
    joint_acceleration: Any,
    poses: Any,
    pose_acceleration: Any,
    loop: Controller,
    plant: Carrier,
    dt: float,
    substeps: int,
    lsb: float,
    position: Any,
    command: Any,
) -> None:
    """Closed loop on a reference (samples, 4) each from rest at ``position[0]`` under ``command[0]``.

    Writes the motor angles that the encoders read and the commands (samples, 4).
    """
    state = _at_rest(position[0], command[0], plant)
    memory = np.zeros((5, 4))
    for k in range(joints.shape[0]):
        _motor_angles(state.w, plant, position[k])
        for j in range(4):
            position[k, j] = encoder.read(position[k, j], lsb)
        if k == 0:
            control.wake_up(position[0], loop, memory)
        target = Target(joints[k], joint_acceleration[k], poses[k], pose_acceleration[k])
        control.step(target, position[k], loop, memory, command[k])
        _advance(k, state, command, plant, dt, substeps)


@compilation.kernel
def _advance(k: int, state: State, command: Any, plant: Carrier, dt: float, substeps: int) -> None:
    drive.deliver_torques(k, command, state.lag, dt, plant.drive, state.torque)
    h = dt / substeps
    speed = state.motor[1]
    for part in range(substeps):
        for i in range(4):
            speed[i] = 0.0
            for j in range(4):
                speed[i] += plant.motor_map[i, j] * state.v[j if j < 2 else j + 2]
        drive.held_friction(speed, state.bristles, h, plant.drive, state.held)
        runge_kutta.ode4_step(
            accelerations,
            STATES,
            state.w,
            state.v,
            state.held,
            state.torque,
            k * dt + part * h,
            h,
            plant,
            state.motor,
            state.stages,
        )


@compilation.kernel
def _motor_angles(w: Any, plant: Carrier, out: Any) -> None:
    for i in range(4):
        out[i] = 0.0
        for j in range(4):
            out[i] += plant.motor_map[i, j] * (w[j if j < 2 else j + 2] - plant.home[j])


@compilation.kernel
def _at_rest(angle: Any, command: Any, plant: Carrier) -> State:
    w, lag = np.zeros(STATES), np.zeros((2, 4))
    for i in range(4):
        w[i] = plant.home[i] + drive_control.row(i, plant.joint_map, angle)
        lag[:, i] = plant.drive.shaft[i, drive.GAIN] * command[i]
    w[4], w[5] = w[2], w[3]
    return State(
        w,
        np.zeros(STATES),
        np.zeros(STATES),
        np.zeros(STATES),
        lag,
        np.zeros(4),
        np.zeros((5, STATES)),
        np.zeros((3, 4)),
    )
