"""Compiled closed loop of the PepperMill-Carrier: controller every sample, ODE4 steps between."""

import sys
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import root

from .. import compilation, encoder, friction
from .. import control as drive_control
from . import constants, control, displacement, dynamics, kinematics, limb
from .control import Controller, Target
from .controllers import Settings, controller
from .cycle import IndustryCycle, LameCycle
from .dynamics import Constants
from .parameters import PMCParameters

Floats = NDArray[np.float64]

compilation.register_laws(friction, encoder, drive_control, limb, displacement, dynamics, control)


@dataclass(frozen=True)
class Reference:
    """A motion sampled at the controller's times, arrays (samples, 4)."""

    time: Floats  # (samples,) [s]
    poses: Floats
    pose_accelerations: Floats
    joints: Floats
    joint_rates: Floats
    joint_accelerations: Floats


@dataclass(frozen=True)
class Run:
    """What happened, arrays (samples, 4); motor order (L1, R1, L2, R2)."""

    reference: Reference
    joints: Floats  # true ones [m, rad]
    joint_rates: Floats
    measured: Floats  # motor angles read by the encoders [rad]
    command: Floats  # motor torques, limited, held for one sample [N m]
    parameters: PMCParameters

    @property
    def poses(self) -> Floats:
        """True poses (samples, 4)."""
        return kinematics.forward(self.joints, self.parameters.geometry)

    @property
    def diverged(self) -> bool:
        """Whether the loop left the working branch or numbers ran away."""
        return not bool(np.isfinite(self.joints).all())

    def rope_tension(self) -> Floats:
        """Tension of the counterweight's rope at every sample [N]."""
        c = constants.of(self.parameters)
        force = self.command @ constants.motor_map(self.parameters.drive.lead)
        w, rates = tuple(self.joints.T), tuple(self.joint_rates.T)
        second = dynamics.acceleration(w, rates, tuple(force.T), c)
        return np.asarray(dynamics.rope_tension(w, rates, second, c))


def sample_cycle(
    cycle: IndustryCycle | LameCycle,
    parameters: PMCParameters,
    *,
    cycles: float = 1.0,
    sample_time: float = 1e-3,
) -> Reference:
    """Reference of some cycles. Raises ValueError if the cycle leaves the reach of the limbs."""
    time = np.arange(round(cycles * cycle.period / sample_time) + 1, dtype=np.float64) * sample_time
    poses, rates, accelerations = cycle.sample(time)
    dim = parameters.geometry.dimensions
    if np.isnan(kinematics.inverse(poses, parameters.geometry)).any():
        raise ValueError(f"cycle at {cycle.placement} leaves the reach of the limbs")
    motion = displacement.joint_motion(tuple(poses.T), tuple(rates.T), tuple(accelerations.T), dim)
    joints, joint_rates, joint_accelerations = (np.stack(part, axis=-1) for part in motion)
    return Reference(time, poses, accelerations, joints, joint_rates, joint_accelerations)


def run(
    reference: Reference,
    settings: Settings,
    parameters: PMCParameters,
    *,
    believed: PMCParameters | None = None,
    start: ArrayLike | None = None,
    calibration: ArrayLike = (0.0, 0.0),
    substeps: int = 1,
) -> Run:
    """Simulate a closed loop that starts at rest at joints ``start``, by default those of :func:`rest`.

    ``believed`` is the robot in the controller's model, by default the true one. ``calibration`` (2,) is by how much
    the drive angles exceed what the encoders say [rad]. One sample is ``substeps`` ODE4
    steps with the torque held.
    """
    n = len(reference.time)
    sample_time = float(reference.time[1] - reference.time[0])
    home = reference.joints[0]
    loop = controller(settings, believed or parameters, home, sample_time)
    joints, rates, measured, command = (np.full((n, 4), np.nan) for _ in range(4))
    joints[0] = rest(reference, settings, parameters) if start is None else start
    offset = np.concatenate([np.zeros(2), np.asarray(calibration, dtype=float)])
    joints[0] += offset
    lsb = encoder.resolution(parameters.encoder_bits) if parameters.encoder_bits else 0.0
    simulate(
        reference.joints,
        reference.joint_accelerations,
        reference.poses,
        reference.pose_accelerations,
        loop,
        constants.of(parameters),
        parameters.torque_limit,
        sample_time,
        substeps,
        lsb,
        home + offset,
        np.zeros((5, 4)),
        joints,
        rates,
        measured,
        command,
    )
    return Run(reference, joints, rates, measured, command, parameters)


def rest(reference: Reference, settings: Settings, parameters: PMCParameters) -> Floats:
    """Joints (4,) at which the loop rests before it starts to move.

    PD controllers sag under the weight until their torques hold it; model-based ones hold the reference. The
    reference also stands where no equilibrium within the torque limit exists.
    """
    return settle(reference.joints[0], settings, parameters)


def settle(home: Floats, settings: Settings, parameters: PMCParameters) -> Floats:
    """Joints (4,) at which the loop rests when it is asked to hold joints ``home`` (4,); see :func:`rest`."""
    c = constants.of(parameters)
    loop = controller(settings, parameters, home, 1.0)
    if loop.kind != control.FEEDBACK:
        return home

    def unbalanced(psi: Floats) -> Floats:
        joints = home + loop.joint_map @ psi
        force = dynamics.inverse_dynamics(tuple(joints), (0.0,) * 4, (0.0,) * 4, c)
        return np.asarray(loop.joint_map.T @ np.array(force) + loop.kp @ psi)

    found = root(unbalanced, np.zeros(4), tol=1e-12)
    needed = np.abs(loop.kp @ found.x).max()
    return home + loop.joint_map @ found.x if needed < parameters.torque_limit else home


def ode4_step(w: Any, rate: Any, force: Any, dt: float, c: Constants) -> Any:
    """One classical Runge-Kutta step under held joint forces: (joints, rates), tuples of 4."""
    a1 = dynamics.acceleration(w, rate, force, c)
    v2 = _ahead(rate, a1, 0.5 * dt)
    a2 = dynamics.acceleration(_ahead(w, rate, 0.5 * dt), v2, force, c)
    v3 = _ahead(rate, a2, 0.5 * dt)
    a3 = dynamics.acceleration(_ahead(w, v2, 0.5 * dt), v3, force, c)
    v4 = _ahead(rate, a3, dt)
    a4 = dynamics.acceleration(_ahead(w, v3, dt), v4, force, c)
    return _ahead(w, _mean(rate, v2, v3, v4), dt), _ahead(rate, _mean(a1, a2, a3, a4), dt)


def _ahead(x: Any, slope: Any, dt: Any) -> Any:
    return (
        x[0] + dt * slope[0],
        x[1] + dt * slope[1],
        x[2] + dt * slope[2],
        x[3] + dt * slope[3],
    )


def _mean(a: Any, b: Any, c: Any, d: Any) -> Any:
    return (
        (a[0] + 2.0 * (b[0] + c[0]) + d[0]) / 6.0,
        (a[1] + 2.0 * (b[1] + c[1]) + d[1]) / 6.0,
        (a[2] + 2.0 * (b[2] + c[2]) + d[2]) / 6.0,
        (a[3] + 2.0 * (b[3] + c[3]) + d[3]) / 6.0,
    )


def joint_forces(torque: Any, motor_map: Any) -> Any:
    """Joint forces (4) of motor torques (4): the transpose of the motor angles per joints."""
    t = torque
    m = motor_map
    return (
        m[0, 0] * t[0] + m[1, 0] * t[1] + m[2, 0] * t[2] + m[3, 0] * t[3],
        m[0, 1] * t[0] + m[1, 1] * t[1] + m[2, 1] * t[2] + m[3, 1] * t[3],
        m[0, 2] * t[0] + m[1, 2] * t[1] + m[2, 2] * t[2] + m[3, 2] * t[3],
        m[0, 3] * t[0] + m[1, 3] * t[1] + m[2, 3] * t[2] + m[3, 3] * t[3],
    )


def read_encoders(joints: Any, motor_map: Any, home: Any, lsb: float, psi: Any) -> None:
    """Motor angles ``psi`` (4,) from home, as the encoders read them."""
    for i in range(4):
        angle = 0.0
        for j in range(4):
            angle += motor_map[i, j] * (joints[j] - home[j])
        psi[i] = encoder.read(angle, lsb)


compilation.register_laws(sys.modules[__name__])


@compilation.kernel
def simulate(
    reference: Any,
    joint_acceleration: Any,
    poses: Any,
    pose_acceleration: Any,
    loop: Controller,
    plant: Constants,
    limit: float,
    dt: float,
    substeps: int,
    lsb: float,
    encoder_home: Any,
    memory: Any,
    joints: Any,
    rates: Any,
    measured: Any,
    command: Any,
) -> None:
    """Fill the last four arrays (samples, 4) from rest at ``joints[0]``; stops at the first NaN.

    The encoders read zero at the joints ``encoder_home`` (4,).
    """
    samples = reference.shape[0]
    w = (joints[0, 0], joints[0, 1], joints[0, 2], joints[0, 3])
    v = (0.0, 0.0, 0.0, 0.0)
    step = dt / substeps
    for k in range(samples):
        for i in range(4):
            joints[k, i], rates[k, i] = w[i], v[i]
        read_encoders(joints[k], loop.motor_map, encoder_home, lsb, measured[k])
        if k == 0:
            control.wake_up(measured[0], loop, memory)
        target = Target(reference[k], joint_acceleration[k], poses[k], pose_acceleration[k])
        control.step(target, measured[k], loop, memory, command[k])
        for i in range(4):
            command[k, i] = drive_control.clip(command[k, i], limit)
        force = joint_forces(command[k], loop.motor_map)
        for _ in range(substeps):
            w, v = ode4_step(w, v, force, step, plant)
        if np.isnan(w[0] + w[1] + w[2] + w[3]):
            break


@compilation.kernel
def one_sample(
    reference: Any,
    joint_acceleration: Any,
    psi: Any,
    loop: Controller,
    plant: Constants,
    dt: float,
    memory: Any,
    w: Any,
    v: Any,
    command: Any,
) -> Any:
    """One sample of a loop whose reference is in joints (4,): writes ``command`` (4,), returns joints and rates.

    ``psi`` (4,) are the motor angles read, ``w`` and ``v`` the true joints and rates as tuples. Not for controllers in
    the pose.
    """
    target = Target(reference, joint_acceleration, reference, joint_acceleration)
    control.step(target, psi, loop, memory, command)
    return ode4_step(w, v, joint_forces(command, loop.motor_map), dt, plant)
