"""Compiled loops over ``furuta``: the rotary pendulum under its sampled control law, or without it."""

from typing import Any, NamedTuple

import numpy as np

from . import compilation, friction, furuta, joint
from .joint import DELAY, GAIN, LAG, LIMIT

compilation.register_laws(friction, joint, furuta)


class Balancer(NamedTuple):
    """Two PD loops on arm and pendulum whose outputs add, with a filtered derivative, and a limit.

    ``u = clip(-sum(kp e + kd D(e)) + feedforward)``, ``D = cutoff s / (s + cutoff)`` by backward Euler.
    """

    kp: Any  # (2,) [V/rad]
    kd: Any  # (2,) [V s/rad]
    cutoff: float  # [rad/s]
    limit: float  # [V]


@compilation.kernel
def balance(
    reference: Any, position: Any, feedforward: Any, law: Balancer, dt: float, out: Any
) -> None:
    """Commands ``out`` (S, 1) [V] of the law for logged positions (S, 2)."""
    before, slope = np.zeros(2), np.zeros(2)
    for s in range(len(reference)):
        out[s, 0] = command_of(reference[s], position[s], feedforward[s], law, dt, before, slope)


@compilation.kernel
def command_of(
    reference: Any, position: Any, feedforward: float, law: Balancer, dt: float, before: Any,
    slope: Any,
) -> float:  # fmt: skip
    """Command [V] of one sample; moves the law's memory on, errors ``before`` and ``slope`` (2,)."""
    u = feedforward
    for i in range(2):
        e = reference[i] - position[i]
        slope[i] = (slope[i] + law.cutoff * (e - before[i])) / (1.0 + law.cutoff * dt)
        before[i] = e
        u -= law.kp[i] * e + law.kd[i] * slope[i]
    return min(max(u, -law.limit), law.limit)


@compilation.kernel
def simulate(
    reference: Any, feedforward: Any, first: int, start: Any, phi: Any, joints: Any, volts: float,
    law: Balancer, lsb: float, dt: float, substeps: int, position: Any, command: Any,
) -> None:  # fmt: skip
    """Closed loop from sample ``first`` and the state ``start`` (4,) on, in place.

    ``position`` (S, 2) holds the readings before ``first``, which the law has seen; it and ``command``
    (S, 1) receive the rest. ``phi`` (4,) are ``furuta.GROUPS``, ``volts`` the torque per volt [N m/V],
    ``lsb`` the encoder step.
    """
    x = start.copy()
    before, slope = np.zeros(2), np.zeros(2)
    torque = np.zeros(1)
    for s in range(len(reference)):
        if s >= first:
            for i in range(2):
                position[s, i] = lsb * np.round(x[i] / lsb) if lsb > 0.0 else x[i]
        command[s, 0] = command_of(
            reference[s], position[s], feedforward[s], law, dt, before, slope
        )
        if s >= first:
            advance(x, torque, command, s, phi, joints, volts, dt, substeps)


@compilation.kernel
def predict(
    command: Any, first: int, start: Any, phi: Any, joints: Any, volts: float, dt: float,
    substeps: int, position: Any,
) -> None:  # fmt: skip
    """Open loop on logged commands from sample ``first``: positions (H, 2) of the samples after it."""
    x = start.copy()
    torque = np.array([volts * joints.actuator[0, GAIN] * command[max(first - 1, 0), 0]])
    for k in range(len(position)):
        advance(x, torque, command, first + k, phi, joints, volts, dt, substeps)
        position[k] = x[:2]


@compilation.kernel
def advance(
    x: Any, torque: Any, command: Any, s: int, phi: Any, joints: Any, volts: float, dt: float,
    substeps: int,
) -> None:  # fmt: skip
    """One sample of the motion, in place: fourth-order Runge-Kutta, efforts held over a substep."""
    h = dt / substeps
    row = joints.actuator[0]
    keep = np.exp(-h / row[LAG]) if row[LAG] > 1e-9 else 0.0
    for k in range(substeps):
        u = joint.held_command(command, s * dt + k * h, row[DELAY], dt, 0)
        wanted = volts * min(max(row[GAIN] * u, -row[LIMIT]), row[LIMIT])
        torque[0] = wanted + (torque[0] - wanted) * keep
        k1 = _slope(x, torque[0], phi, joints.law)
        k2 = _slope(x + 0.5 * h * k1, torque[0], phi, joints.law)
        k3 = _slope(x + 0.5 * h * k2, torque[0], phi, joints.law)
        k4 = _slope(x + h * k3, torque[0], phi, joints.law)
        x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


@compilation.kernel
def _slope(x: Any, torque: float, phi: Any, law: Any) -> Any:
    """Rates (4,) of arm angle, pendulum angle and their rates."""
    J, P, C, G = phi
    m11, m12, m22 = furuta.mass_matrix(x[1], J, P, C)
    h1, h2 = furuta.bias(x[1], x[2], x[3], P, C, G)
    load = -G * np.sin(x[1])
    t1 = torque - h1 - joint.resistance(law[0], x[0], x[2], torque, 0.0)
    t2 = -h2 - joint.resistance(law[1], x[1], x[3], 0.0, load)
    det = m11 * m22 - m12 * m12
    return np.array([x[2], x[3], (m22 * t1 - m12 * t2) / det, (m11 * t2 - m12 * t1) / det])
