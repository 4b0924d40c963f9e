"""The closed loop's laws as plain functions of two shafts, for peers that call back into Python."""

import math
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

Pair = Sequence[Any]


class Constants(NamedTuple):
    """Constants of the loop in SI units, in the order of the struct in ``c_drive_loop.c``."""

    m11: float
    m12: float
    beta: float
    gamma: float
    delta: float
    eta: float
    width: float
    kp: float
    kd: float
    cutoff: float
    dt: float
    lsb: float


def friction(
    c: Constants, left: Any, right: Any, tanh: Callable[[Any], Any] = math.tanh
) -> tuple[Any, Any]:
    """Friction torques [N m] at the two shafts from their speeds [rad/s]."""
    slip = left - right
    collar = 0.5 * c.gamma * slip + c.eta * tanh(slip / c.width)
    return (
        c.beta * left + c.delta * tanh(left / c.width) + collar,
        c.beta * right + c.delta * tanh(right / c.width) - collar,
    )


def acceleration(
    c: Constants, speed: Pair, torque: Pair, tanh: Callable[[Any], Any] = math.tanh
) -> list[Any]:
    """Accelerations [rad/s^2] of the two shafts."""
    rub = friction(c, speed[0], speed[1], tanh)
    left, right = torque[0] - rub[0], torque[1] - rub[1]
    det = c.m11 * c.m11 - c.m12 * c.m12
    return [(c.m11 * left - c.m12 * right) / det, (c.m11 * right - c.m12 * left) / det]


def ode4_step(
    c: Constants, state: Pair, torque: Pair, tanh: Callable[[Any], Any] = math.tanh
) -> list[Any]:
    """State (4,), angles then speeds, one sample later under a held torque."""
    v = (state[2], state[3])
    a1 = acceleration(c, v, torque, tanh)
    a2 = acceleration(c, ahead(c, v, a1, 0.5), torque, tanh)
    a3 = acceleration(c, ahead(c, v, a2, 0.5), torque, tanh)
    a4 = acceleration(c, ahead(c, v, a3, 1.0), torque, tanh)
    return ode4_sum(c, state, (a1, a2, a3, a4))


def ahead(c: Constants, speed: Pair, slope: Pair, part: float) -> list[Any]:
    """Speeds after ``part`` of a sample at constant acceleration."""
    return [speed[j] + part * c.dt * slope[j] for j in (0, 1)]


def ode4_sum(c: Constants, state: Pair, stages: Sequence[Pair]) -> list[Any]:
    """State (4,) one sample later from the accelerations of the four stages."""
    h, (a1, a2, a3, a4) = c.dt, stages
    both = (0, 1)
    angles = [state[j] + h * state[2 + j] + h * h / 6 * (a1[j] + a2[j] + a3[j]) for j in both]
    speeds = [state[2 + j] + h / 6 * (a1[j] + 2 * a2[j] + 2 * a3[j] + a4[j]) for j in both]
    return angles + speeds


def read_encoder(c: Constants, angles: Pair) -> list[float]:
    """What the encoders read [rad]."""
    if c.lsb <= 0.0:
        return [float(angles[0]), float(angles[1])]
    return [c.lsb * math.floor(angle / c.lsb + 0.5) for angle in (angles[0], angles[1])]


def pd(c: Constants, error: Pair, low: Pair) -> list[Any]:
    """Command [N m] from the error [rad] and its low-passed value."""
    return [c.kp * error[j] + c.kd * c.cutoff * (error[j] - low[j]) for j in (0, 1)]


def low_pass(c: Constants, error: Pair, low: Pair) -> list[Any]:
    """Low-passed error one sample later."""
    decay = math.exp(-c.cutoff * c.dt)
    return [error[j] + decay * (low[j] - error[j]) for j in (0, 1)]


def difference(a: Pair, b: Pair) -> list[Any]:
    """``a - b`` of the two shafts."""
    return [a[0] - b[0], a[1] - b[1]]
