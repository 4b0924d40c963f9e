"""The C-drive as two separate screws and a collar; time stepping at 20 or 5 microseconds.

Coordinates are the collar's travel ``u`` [m] and turn ``theta`` [rad], and the two screw angles
``psi_L``, ``psi_R`` [rad]. The nuts ask for ``psi_L = k u + theta``, ``psi_R = -k u + theta``,
``k = 2 pi/lead`` (2.4). With rigid nuts the screws follow the collar and two coordinates remain,

    (m + 2 I_h k^2) u'' = k (tau_L - tau_R) + ...,   (I_c + 2 I_h) theta'' = tau_L + tau_R + ...;

with springs in the nuts, or clearance, screws and collar are separate bodies joined by the torque
``K pen (1 + c pen')`` of a one-sided contact. Steps are Moreau's midpoint rule: positions by half
steps about one velocity update, friction impulses solved at the velocity level.
"""

from typing import NamedTuple

import numba
import numpy as np

from .controllers import Controller
from .controllers import torque as controller_torque
from .friction import ELEMENTS, clip, falling, maxwell_slip, slide_two
from .motion import FINE_TIME, SAMPLE_TIME, Array

LEAD = 0.060  # m/rev, screws of opposite hand
TURNS = 2 * np.pi / LEAD  # k, rad/m
FINE = round(SAMPLE_TIME / FINE_TIME)  # true positions per sample
RIGID_STEPS, FLEXIBLE_STEPS = 50, 200  # per sample
ENCODER_LSB = 2 * np.pi / 2**13  # rad
COLLAR = 2  # contacts are left screw, right screw, collar
TRANSLATION, ROTATION = 0.7515e-3, 4.5109e-3  # eigenvalues of M (5.2) [kg m^2]
MASS = 5.0  # kg; see Machine
ROTOR = TRANSLATION - MASS / (2 * TURNS**2)
Sides = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


class Machine(NamedTuple):
    """One drive with everything that may be wrong with it; the defaults are the nominal machine.

    The split of the nominal inertia M (5.2) among collar and screws is not printed: the collar of
    5 kg (3.28 kg of middle part, eq. 3.6, and two ends) fixes the other two.
    """

    mass: float = MASS  # collar [kg]
    turning_inertia: float = 2 * (ROTATION - ROTOR)  # collar about the axis [kg m^2]
    rotor_inertia: float = ROTOR  # one screw and motor [kg m^2]
    beta: tuple[float, float] = (0.004148, 0.004148)  # screw bearings [N m s/rad]
    gamma: float = 0.002792  # nuts [N m s/rad]
    coulomb: Sides = ((0.0, 0.0), (0.0, 0.0), (0.0, 0.0))  # L, R, collar; forward, backward [Nm]
    stribeck_ratio: float = 1.0  # breakaway over sliding friction
    stribeck_speed: float = 5.0  # rad/s
    load_friction: tuple[float, float] = (0.0, 0.0)  # friction over motor torque
    presliding: float = 0.0  # reach of the elastic elements [rad]; 0 for stiction
    warm_viscous: float = 0.0  # viscous friction above its warm value, when cold
    warm_coulomb: float = 0.0  # dry friction that fades with warmth [Nm]
    warm_time: float = 10.0  # s of running
    stiffness: float = 0.0  # nut and coupling [Nm/rad]; 0 for rigid
    coupling_damping: float = 0.0  # N m s/rad
    gap: tuple[float, float] = (0.0, 0.0)  # clearance, total [rad]
    delay: float = 0.0  # of the command [s]
    lag: float = 0.0  # of the torque loop [s]
    lag_order: int = 1  # equal first-order stages that share the lag
    limit: float = 1e9  # Nm
    gain: tuple[float, float] = (1.0, 1.0)  # motor torque over command
    ripple: tuple[float, float] = (0.0, 0.0)  # Nm
    ripple_order: float = 0.0  # periods per revolution
    ripple_phase: float = 0.0  # rad
    bias_collar: tuple[float, float] = (0.0, 0.0)  # force along u [N], torque about theta [Nm]
    bias_screw: tuple[float, float] = (0.0, 0.0)  # Nm
    lsb: float = ENCODER_LSB  # rad
    scale: tuple[float, float] = (1.0, 1.0)  # encoder reading over angle
    offset: tuple[float, float] = (0.0, 0.0)  # rad
    hardening: float = 0.0  # cubic spring on the collar about mid-stroke [N/m^3]
    middle: float = -0.1  # its centre [m]
    patch: float = 0.0  # friction of a rough stretch of the stroke [N]
    patch_centre: float = 0.0  # m
    patch_width: float = 0.01  # m
    wave: tuple[float, float] = (
        0.0,
        0.0,
    )  # disturbance periodic in time: N along u, Nm about theta
    wave_frequency: float = 0.0  # Hz
    drag: tuple[float, float] = (0.0, 0.0)  # square-law, N s^2/m^2 and N m s^2
    hidden_mass: float = 0.0  # sprung on the collar [kg]
    hidden_frequency: float = 0.0  # Hz
    hidden_damping: float = 0.0  # ratio
    log_scale: tuple[float, float] = (1.0, 1.0)  # logged over controller's position
    log_offset: tuple[float, float] = (0.0, 0.0)  # rad, in the log only
    log_clock: float = 0.0  # age of a logged position at its time stamp [s]
    log_late: int = 0  # samples by which positions and torques lag time and reference


class Program(NamedTuple):
    """One run: reference, its acceleration, noise and events, each (n samples, 2) unless said."""

    reference: Array  # rad
    acceleration: Array  # rad/s^2
    encoder_noise: Array  # rad
    dropped: Array  # (n,) 1 where a new command is lost and the last one is held
    kicks: Array  # (n,) force on the collar during the sample [N]
    start: float  # running time of the machine before this run [s]


class Scratch(NamedTuple):
    """Arrays one run works in: inverse inertias, contact directions, impulses and their bounds."""

    mobility: Array
    directions: Array
    before: Array
    force: Array
    limits: Array
    lower: Array
    upper: Array
    impulse: Array


@numba.njit(cache=True)
def _scratch(m: Machine, flexible: bool) -> Scratch:
    if flexible:
        inertia = np.array([m.mass, m.turning_inertia, m.rotor_inertia, m.rotor_inertia])
    else:
        sliding = m.mass + 2 * m.rotor_inertia * TURNS**2
        inertia = np.array([sliding, m.turning_inertia + 2 * m.rotor_inertia])
    n = len(inertia)
    directions = np.array([[TURNS, 1.0], [-TURNS, 1.0], [2 * TURNS, 0.0]])
    bounds = (np.zeros(2), np.zeros(3), np.zeros(3), np.zeros(3))
    return Scratch(1.0 / inertia, directions, np.zeros(n), np.zeros(n), *bounds)


@numba.njit(cache=True)
def warm(m: Machine, time: float) -> float:
    """Share of the cold state that is left."""
    return np.exp(-time / m.warm_time)


@numba.njit(cache=True)
def dry_limits(
    m: Machine, i: int, rate: float, torque: float, travel: float, time: float, out: Array
) -> None:
    """Greatest dry torque [Nm] at contact ``i``, forward and backward, into ``out``."""
    curve = falling(rate, m.stribeck_ratio, m.stribeck_speed)
    extra = m.warm_coulomb * warm(m, time) if i < COLLAR else 0.0
    if i < COLLAR:
        extra += m.load_friction[i] * abs(torque)
    else:
        extra += m.patch * np.exp(-(((travel - m.patch_centre) / m.patch_width) ** 2)) / (2 * TURNS)
    out[0] = m.coulomb[i][0] * curve + extra
    out[1] = m.coulomb[i][1] * curve + extra


@numba.njit(cache=True)
def drive_torque(m: Machine, i: int, command: float, angle: float, lag: Array, h: float) -> float:
    """Torque on rotor ``i``: limit, gain, lag of one or two stages, ripple over the turn."""
    torque = clip(command, -m.limit, m.limit) * m.gain[i]
    if m.lag > 0.0:
        share = 1.0 - np.exp(-h * m.lag_order / m.lag)
        for stage in range(m.lag_order):
            lag[i, stage] += share * (torque - lag[i, stage])
            torque = lag[i, stage]
    return torque + m.ripple[i] * np.sin(m.ripple_order * angle + m.ripple_phase + i)


@numba.njit(cache=True)
def collar_load(
    m: Machine, q: Array, v: Array, kick: float, time: float, hidden: Array, load: Array
) -> None:
    """Force along u and torque about theta from outside the drive, into ``load``."""
    wave = np.sin(2 * np.pi * m.wave_frequency * time)
    load[0] = m.bias_collar[0] + kick + m.wave[0] * wave - m.drag[0] * v[0] * abs(v[0])
    load[0] -= m.hardening * ((q[0] - m.middle) ** 3 + m.middle**3)
    load[1] = m.bias_collar[1] + m.wave[1] * wave - m.drag[1] * v[1] * abs(v[1])
    if m.hidden_mass > 0.0:
        w = 2 * np.pi * m.hidden_frequency
        pull = w * w * (hidden[0] - q[0]) + 2 * m.hidden_damping * w * (hidden[1] - v[0])
        load[0] += m.hidden_mass * pull


@numba.njit(cache=True)
def rigid_step(
    m: Machine,
    h: float,
    q: Array,
    middle: Array,
    v: Array,
    torque: Array,
    load: Array,
    time: float,
    elements: Array,
    s: Scratch,
) -> None:
    """One step with rigid nuts: ``q``, ``v`` are travel and turn; screws follow."""
    thick = 1.0 + m.warm_viscous * warm(m, time)
    dry = False
    s.before[:] = v
    s.force[0], s.force[1] = load[0], load[1]
    for i in range(3):
        rate = s.directions[i, 0] * v[0] + s.directions[i, 1] * v[1]
        motor = torque[i] if i < COLLAR else 0.0
        dry_limits(m, i, rate, motor, middle[0], time, s.limits)
        if m.presliding > 0.0:
            level = s.limits[0] if rate > 0 else s.limits[1]
            motor -= maxwell_slip(elements[i], rate * h, m.presliding, level)
            s.limits[:] = 0.0
        s.lower[i], s.upper[i] = -h * s.limits[1], h * s.limits[0]
        dry = dry or s.limits[0] > 0.0 or s.limits[1] > 0.0
        s.force[0] += s.directions[i, 0] * motor
        s.force[1] += s.directions[i, 1] * motor
    for _ in range(2):  # viscous force at the middle of the step
        left, right = TURNS * v[0] + v[1], -TURNS * v[0] + v[1]
        slip = 0.5 * m.gamma * (left - right)
        left, right = thick * (m.beta[0] * left + slip), thick * (m.beta[1] * right - slip)
        v[0] = s.before[0] + 0.5 * h * s.mobility[0] * (s.force[0] - TURNS * (left - right))
        v[1] = s.before[1] + 0.5 * h * s.mobility[1] * (s.force[1] - left - right)
    for j in range(2):
        v[j] = 2 * v[j] - s.before[j]
    if dry:
        for i in range(3):
            s.impulse[i] = clip(s.impulse[i], s.lower[i], s.upper[i])
            v[0] -= s.mobility[0] * s.directions[i, 0] * s.impulse[i]
            v[1] -= s.mobility[1] * s.directions[i, 1] * s.impulse[i]
        slide_two(v, s.mobility, s.directions, s.lower, s.upper, s.impulse)
    for j in range(2):
        q[j] += 0.5 * h * (s.before[j] + v[j])


@numba.njit(cache=True)
def nut_torque(m: Machine, i: int, wind: float, wind_rate: float) -> float:
    """Torque from screw ``i`` to the collar: a spring behind a gap, its damping only in contact."""
    pen = abs(wind) - 0.5 * m.gap[i]
    if pen <= 0.0:
        return 0.0
    side = 1.0 if wind > 0 else -1.0
    soft = 1.0 if m.gap[i] == 0.0 else min(1.0, pen * m.stiffness / 0.05)
    torque = m.stiffness * pen + soft * m.coupling_damping * side * wind_rate
    return side * max(torque, 0.0) if m.gap[i] > 0.0 else side * torque


@numba.njit(cache=True)
def flexible_step(
    m: Machine,
    h: float,
    q: Array,
    middle: Array,
    v: Array,
    torque: Array,
    load: Array,
    time: float,
    elements: Array,
    s: Scratch,
) -> None:
    """One step of four bodies' coordinates (travel, turn, left screw, right screw)."""
    thick = 1.0 + m.warm_viscous * warm(m, time)
    left, right = TURNS * middle[0] + middle[1], -TURNS * middle[0] + middle[1]
    left_rate, right_rate = TURNS * v[0] + v[1], -TURNS * v[0] + v[1]
    nut_left = nut_torque(m, 0, middle[2] - left, v[2] - left_rate)
    nut_right = nut_torque(m, 1, middle[3] - right, v[3] - right_rate)
    slip = 2 * TURNS
    s.force[0] = load[0] + TURNS * (nut_left - nut_right)
    s.force[0] -= thick * 0.5 * m.gamma * slip**2 * v[0]
    s.force[1] = load[1] + nut_left + nut_right
    s.force[2] = torque[0] - nut_left - thick * m.beta[0] * v[2]
    s.force[3] = torque[1] - nut_right - thick * m.beta[1] * v[3]
    for j in range(4):
        s.before[j] = v[j]
        v[j] += h * s.mobility[j] * s.force[j]
    for i in range(3):
        body, ratio = (0, slip) if i == COLLAR else (2 + i, 1.0)
        motor = torque[i] if i < COLLAR else 0.0
        rate = ratio * s.before[body]
        dry_limits(m, i, rate, motor, middle[0], time, s.limits)
        if m.presliding > 0.0:
            level = s.limits[0] if rate > 0 else s.limits[1]
            brake = h * ratio * maxwell_slip(elements[i], rate * h, m.presliding, level)
        else:
            stop = v[body] / s.mobility[body]
            brake = clip(stop, -h * ratio * s.limits[1], h * ratio * s.limits[0])
        v[body] -= s.mobility[body] * brake
    for j in range(4):
        q[j] += 0.5 * h * (s.before[j] + v[j])


@numba.njit(cache=True)
def encode(m: Machine, i: int, angle: float, noise: float) -> float:
    """Encoder reading [rad]: gain, offset, noise, then the nearest count."""
    return np.round((m.scale[i] * angle + m.offset[i] + noise) / m.lsb) * m.lsb


@numba.njit(cache=True)
def run(m: Machine, c: Controller, p: Program) -> tuple[Array, Array, Array]:
    """Closed loop over one program.

    Returns the readings (n, 2) [rad], the commands (n, 2) [Nm] and the true screw angles
    (n FINE, 2) [rad] every 0.1 ms.
    """
    n = p.reference.shape[0]
    flexible = m.stiffness > 0.0
    steps = FLEXIBLE_STEPS if flexible else RIGID_STEPS
    h = SAMPLE_TIME / steps
    late = int(np.round(m.delay / h))
    readings, commands, applied = np.zeros((n, 2)), np.zeros((n, 2)), np.zeros((n, 2))
    fine = np.zeros((n * FINE, 2))
    q, v = np.zeros(4 if flexible else 2), np.zeros(4 if flexible else 2)
    middle = np.zeros_like(q)
    angles, torque, load = np.zeros(2), np.zeros(2), np.zeros(2)
    lag, elements, scratch = np.zeros((2, 2)), np.zeros((3, ELEMENTS)), _scratch(m, flexible)
    state, hidden = np.zeros((2, 3)), np.zeros(2)
    for k in range(n):
        for i in range(2):
            readings[k, i] = encode(m, i, angles[i], p.encoder_noise[k, i])
        commands[k] = _control(c, p.reference[k], readings[k], p.acceleration[k], state)
        applied[k] = applied[k - 1] if k > 0 and p.dropped[k] > 0 else commands[k]
        for j in range(steps):
            if j % (steps // FINE) == 0:
                fine[k * FINE + j // (steps // FINE)] = angles
            source = (k * steps + j - late) // steps
            time = p.start + (k * steps + j) * h
            middle[:] = q + 0.5 * h * v
            for i in range(2):
                command = applied[source, i] if source >= 0 else 0.0
                torque[i] = drive_torque(m, i, command, angles[i], lag, h) + m.bias_screw[i]
            collar_load(m, middle, v, p.kicks[k], time, hidden, load)
            _move_hidden(m, h, middle, v, hidden)
            if flexible:
                flexible_step(m, h, q, middle, v, torque, load, time, elements, scratch)
                angles[:] = q[2:]
            else:
                rigid_step(m, h, q, middle, v, torque, load, time, elements, scratch)
                angles[0], angles[1] = TURNS * q[0] + q[1], -TURNS * q[0] + q[1]
    return readings, commands, fine


@numba.njit(cache=True)
def _control(
    c: Controller, reference: Array, reading: Array, acceleration: Array, state: Array
) -> Array:
    modes = np.empty((3, 2))
    modes[0] = _modes(reference - reading)
    modes[1] = _modes(reading)
    modes[2] = _modes(acceleration)
    tau = controller_torque(c, modes[0], modes[1], modes[2], state)
    return np.array([tau[0] + tau[1], tau[1] - tau[0]])


@numba.njit(cache=True)
def _modes(pair: Array) -> Array:
    return np.array([0.5 * (pair[0] - pair[1]), 0.5 * (pair[0] + pair[1])])


@numba.njit(cache=True)
def _move_hidden(m: Machine, h: float, q: Array, v: Array, hidden: Array) -> None:
    w = 2 * np.pi * m.hidden_frequency
    pull = w * w * (q[0] - hidden[0]) + 2 * m.hidden_damping * w * (v[0] - hidden[1])
    hidden[1] += h * pull
    hidden[0] += h * hidden[1]
