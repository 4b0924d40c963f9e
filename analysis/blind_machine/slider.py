"""A motor, ball screw and carriage as one body or two; time stepping at 20 or 5 microseconds.

``M q'' + F_v q' = force + ...`` of the carriage [m]; with a spring or a gap in the screw the motor
side carries ``motor_share`` of the mass and the encoder sits on the load. The controller is the
cascade of the EMPS benchmark (Janot, Gautier, Brunot 2019), sampled at 1 ms:

    u = k_v (k_p (q_ref - q) - dq),   dq = (qf[k] - qf[k-1])/T,   qf = (q[k] + q[k-1])/2.
"""

from typing import NamedTuple

import numba
import numpy as np

from .friction import ELEMENTS, clip, falling, maxwell_slip
from .motion import FINE_TIME, SAMPLE_TIME, Array

KP, KV, SATURATION, FORCE_PER_VOLT = 160.18, 243.45, 10.0, 35.15065188248547
ENCODER_LSB = 5e-8  # m
FINE = round(SAMPLE_TIME / FINE_TIME)
RIGID_STEPS, FLEXIBLE_STEPS = 50, 200  # per sample


class Slider(NamedTuple):
    """One carriage with everything that may be wrong with it; the defaults are the stated machine."""

    mass: float = 95.1089  # kg
    viscous: float = 203.5034  # N s/m
    coulomb: tuple[float, float] = (0.0, 0.0)  # forward, backward [N]
    stribeck_ratio: float = 1.0
    stribeck_speed: float = 0.01  # m/s
    load_friction: float = 0.0  # friction over motor force
    presliding: float = 0.0  # m; 0 for stiction
    warm_viscous: float = 0.0
    warm_coulomb: float = 0.0  # N
    warm_time: float = 100.0  # s
    stiffness: float = 0.0  # N/m; 0 for rigid
    coupling_damping: float = 0.0  # N s/m
    gap: float = 0.0  # m, total
    motor_share: float = 0.6  # of the mass, once it can move apart
    delay: float = 0.0  # s
    lag: float = 0.0  # s
    lag_order: int = 1
    limit: float = 1e9  # N
    gain: float = 1.0
    ripple: float = 0.0  # N
    ripple_length: float = 0.01  # m
    ripple_phase: float = 0.0  # rad
    bias: float = 0.0  # N
    lsb: float = ENCODER_LSB  # m
    scale: float = 1.0
    offset: float = 0.0  # m
    log_scale: float = 1.0
    log_offset: float = 0.0  # m, in the log only
    log_clock: float = 0.0  # s
    log_late: int = 0  # samples


@numba.njit(cache=True)
def run(m: Slider, reference: Array, noise: Array, start: float) -> tuple[Array, Array, Array]:
    """Readings (n,) [m], commands (n,) [V] and true positions (n FINE,) [m] of one closed-loop run."""
    n = len(reference)
    flexible = m.stiffness > 0.0
    steps = FLEXIBLE_STEPS if flexible else RIGID_STEPS
    h = SAMPLE_TIME / steps
    late = int(np.round(m.delay / h))
    readings, commands, fine = np.zeros(n), np.zeros(n), np.zeros(n * FINE)
    lag, elements = np.zeros(2), np.zeros(ELEMENTS)
    motor, motor_rate, load, load_rate = 0.0, 0.0, 0.0, 0.0
    last, last_filtered = 0.0, 0.0
    for k in range(n):
        readings[k] = np.round((m.scale * load + m.offset + noise[k]) / m.lsb) * m.lsb
        if k == 0:
            last = last_filtered = readings[0]
        filtered = 0.5 * (readings[k] + last)
        rate = (filtered - last_filtered) / SAMPLE_TIME
        commands[k] = clip(KV * (KP * (reference[k] - readings[k]) - rate), -SATURATION, SATURATION)
        last, last_filtered = readings[k], filtered
        for j in range(steps):
            if j % (steps // FINE) == 0:
                fine[k * FINE + j // (steps // FINE)] = load
            source = (k * steps + j - late) // steps
            command = commands[source] if source >= 0 else 0.0
            warmth = np.exp(-(start + (k * steps + j) * h) / m.warm_time)
            force = _drive(m, FORCE_PER_VOLT * command, motor, lag, h) + m.bias
            coupling = _coupling(m, motor + 0.5 * h * motor_rate - load - 0.5 * h * load_rate,
                                 motor_rate - load_rate) if flexible else 0.0  # fmt: skip
            inertia = m.mass * m.motor_share if flexible else m.mass
            thick = m.viscous * (1.0 + m.warm_viscous * warmth)
            free = motor_rate + h / inertia * (force - coupling)
            free /= 1.0 + h * thick / inertia  # implicit: never gains energy
            limits = _dry(m, motor_rate, force, warmth)
            if m.presliding > 0.0:
                level = limits[0] if motor_rate > 0 else limits[1]
                brake = h * maxwell_slip(elements, motor_rate * h, m.presliding, level)
            else:
                brake = clip(free * inertia, -h * limits[1], h * limits[0])
            free -= brake / inertia
            motor += 0.5 * h * (motor_rate + free)
            motor_rate = free
            if flexible:
                faster = load_rate + h * coupling / (m.mass * (1.0 - m.motor_share))
                load += 0.5 * h * (load_rate + faster)
                load_rate = faster
            else:
                load, load_rate = motor, motor_rate
    return readings, commands, fine


@numba.njit(cache=True)
def _drive(m: Slider, command: float, position: float, lag: Array, h: float) -> float:
    force = clip(command, -m.limit, m.limit) * m.gain
    if m.lag > 0.0:
        share = 1.0 - np.exp(-h * m.lag_order / m.lag)
        for stage in range(m.lag_order):
            lag[stage] += share * (force - lag[stage])
            force = lag[stage]
    turn = 2 * np.pi * position / m.ripple_length
    return force + m.ripple * np.sin(turn + m.ripple_phase)


@numba.njit(cache=True)
def _coupling(m: Slider, wind: float, wind_rate: float) -> float:
    pen = abs(wind) - 0.5 * m.gap
    if pen <= 0.0:
        return 0.0
    side = 1.0 if wind > 0 else -1.0
    force = m.stiffness * pen + m.coupling_damping * side * wind_rate
    return side * max(force, 0.0) if m.gap > 0.0 else side * force


@numba.njit(cache=True)
def _dry(m: Slider, rate: float, force: float, warmth: float) -> tuple[float, float]:
    curve = falling(rate, m.stribeck_ratio, m.stribeck_speed)
    extra = m.warm_coulomb * warmth + m.load_friction * abs(force)
    return m.coulomb[0] * curve + extra, m.coulomb[1] * curve + extra
