r"""Control laws of the drives, one sample at a time.

1. filtered derivative (5.1): :math:`F(s) = N s / (N + s)`, exact for a held input;
2. PD and task-space PD (4.32, 4.37): :math:`\tau = K_P e + K_D \dot e`, K full (n, n) matrices;
3. computed torque (4.33-4.35): :math:`\tau = M (\ddot\psi_d + K_P e + K_D \dot e) + c D \dot{\tilde\psi}`;
4. minimum-order observer (4.22): :math:`\dot\kappa = U \kappa + V \sigma + Z u`, exact for held
   inputs;
5. cascade P-P: :math:`u = k_v (k_p (r - q) - \dot q)`, clipped.

Angles rad, torques N m, time s, per sample k of period dt. Source: Friedlaender 2015 for (1)-(4);
(5) is the law of the EMPS benchmark (Janot, Gautier and Brunot 2019).
"""

from typing import Any

import numpy as np

from .friction import Scalar


def derivative_decay(cutoff: Scalar, dt: Scalar) -> Scalar:
    """Per-sample decay a = exp(-N dt) of the filter (5.1) with cut-off N [rad/s]."""
    return np.exp(-cutoff * dt)


def filtered_derivative(signal: Scalar, memory: Scalar, cutoff: Scalar) -> Scalar:
    """Output N (signal - memory) of (5.1), where ``memory`` is the low-passed signal."""
    return cutoff * (signal - memory)


def low_pass(signal: Scalar, memory: Scalar, decay: Scalar) -> Scalar:
    """Next value of a first-order low-pass whose input is held for one sample."""
    return signal + decay * (memory - signal)


def row(i: int, matrix: Any, vector: Any) -> Any:
    """Row ``i`` of a matrix (n, n) times a vector (n,)."""
    total = matrix[i, 0] * vector[0]
    for j in range(1, len(vector)):
        total += matrix[i, j] * vector[j]
    return total


def plus_row(total: Any, i: int, matrix: Any, vector: Any) -> Any:
    """``total`` plus ``row``: what comes late is multiplied and added in one."""
    for j in range(len(vector)):
        total += matrix[i, j] * vector[j]
    return total


def pid(i: int, kp: Any, ki: Any, kd: Any, error: Any, integral: Any, slope: Any) -> Any:
    """Row ``i`` of (2) with the integral of (4.32): Kp e + Ki int(e) + Kd de/dt."""
    return plus_row(plus_row(row(i, ki, integral), i, kp, error), i, kd, slope)


def inverse_dynamics(i: int, inertia: Any, damping: Any, acceleration: Any, rate: Any) -> Any:
    """Row ``i`` of (3): the torque for the corrected acceleration at the estimated rate (4.35)."""
    return plus_row(row(i, damping, rate), i, inertia, acceleration)


def observed_rate(i: int, from_state: Any, from_position: Any, state: Any, position: Any) -> Any:
    """Row ``i`` of the rate that an observer reads from its state and the position (4.22e)."""
    return plus_row(row(i, from_state, state), i, from_position, position)


def observer_next(
    i: int,
    transition: Any,
    from_position: Any,
    from_torque: Any,
    state: Any,
    position: Any,
    torque: Any,
) -> Any:
    """Row ``i`` of the next state of the observer (4), inputs held over the sample."""
    return row(i, transition, state) + row(i, from_position, position) + row(i, from_torque, torque)


def cascade_p_p(reference: Scalar, position: Scalar, speed: Scalar, kp: Scalar, kv: Scalar) -> Any:
    """Position loop around a velocity loop, both proportional, before the limiter."""
    return kv * (kp * (reference - position) - speed)


def dead_zone(value: Scalar, width: float) -> Any:
    """``value`` moved towards zero by ``width``, a float, and zero within it."""
    return value - clip(value, width)


def clip(value: Scalar, limit: Scalar) -> Scalar:
    """``value`` limited to +-``limit``, a float."""
    return min(max(value, -limit), limit)
