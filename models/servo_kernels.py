"""Compiled loop of servo axes under cascaded control, with a machine of constant inertia as their load.

For motions small enough that the machine's inertia and weight stay those of one posture. The laws are those of
``cascade`` and ``friction``; the currents follow their commands at once, as in Roldan's section 4.1.3.
"""

from typing import Any, NamedTuple

import numpy as np

from . import cascade, compilation, control, friction

compilation.register_laws(friction, control, cascade)


class Loops(NamedTuple):
    """Gains and sample times of equal axes."""

    position_gain: float  # k_v [1/s]
    feedforward: float  # [-]
    filter_time: float  # of the rate command's low-pass [s], 0 for none
    velocity_kp: float  # [A s/rad]
    velocity_ki: float  # [A/rad]
    current_limit: float  # [A]
    velocity_period: float  # [s]
    ratio: int  # velocity samples in one of the position loop


class Axes(NamedTuple):
    """Plant seen from the motors."""

    inertia_inverse: Any  # of motors and machine (n, n) [1/(kg m^2)]
    load: Any  # constant torque of the machine's weight (n,) [N m]
    viscous: float  # [N m s/rad]
    coulomb: float  # [N m]
    sign_rate: float  # [s/rad]
    torque_constant: float  # [N m/A]


@compilation.kernel
def simulate(
    reference: Any, rate: Any, axes: Axes, loops: Loops, substeps: int, angle: Any, torque: Any
) -> None:
    """Motor angles and torques (samples, n) at the velocity loop's samples, from rest at the reference.

    ``reference`` and ``rate`` (ceil(samples / ratio), n) are motor angles [rad] and rates at the position loop's
    samples. The loops wake up holding the machine's weight.
    """
    samples, n = angle.shape
    q, v, command, integral = reference[0].copy(), np.zeros(n), np.zeros(n), np.zeros(n)
    lost, net, current = np.zeros(n), np.zeros(n), np.zeros(n)
    decay = 0.0
    if loops.filter_time > 0.0:
        period = loops.ratio * loops.velocity_period
        decay = control.derivative_decay(1.0 / loops.filter_time, period)
    if loops.velocity_ki > 0.0:
        for j in range(n):
            integral[j] = axes.load[j] / (axes.torque_constant * loops.velocity_ki)
    step = loops.velocity_period / substeps
    for k in range(samples):
        if k % loops.ratio == 0:
            p = k // loops.ratio
            for j in range(n):
                wanted = cascade.rate_command(
                    reference[p, j], q[j], rate[p, j], loops.position_gain, loops.feedforward, 1.0
                )
                command[j] = control.low_pass(wanted, command[j], decay)
        for j in range(n):
            current[j], integral[j] = cascade.proportional_integral(
                command[j] - v[j],
                integral[j],
                loops.velocity_kp,
                loops.velocity_ki,
                loops.current_limit,
                loops.velocity_period,
            )
            angle[k, j] = q[j]
            torque[k, j] = axes.torque_constant * current[j]
        for _ in range(substeps):  # semi-implicit: rates first, positions with the new rates
            for j in range(n):
                lost[j] = friction.sech_dry(
                    v[j], axes.viscous, axes.coulomb, 0.0, 0.0, axes.sign_rate
                )
                net[j] = torque[k, j] - lost[j] - axes.load[j]
            for j in range(n):
                for i in range(n):
                    v[j] += step * axes.inertia_inverse[j, i] * net[i]
            for j in range(n):
                q[j] += step * v[j]
