"""The thesis' three controllers, written from the thesis for the blind machine (sampled at 1 ms).

With the error ``e = psi_d - psi`` of the two screws (4.31), its filtered derivative ``de`` (5.1)
held exactly between samples, and the modes ``(L - R)/2`` (translation), ``(L + R)/2`` (rotation):

    PD              tau = kP e + kD de                                                   (4.32)
    task-space PD   the same in the modes, each with its own gains                       (4.37a)
    computed torque tau = M (psi_d'' + kP e + kD de) + c D psi'                          (4.35)

``psi'`` comes from the minimum-order observer (4.22), one mode at a time:
``kappa' = U kappa + U L psi + tau/(e h)``, ``psi' = h (kappa + L psi)``, ``U = -(1 + L) h = pole``,
``h = g/e`` the mode's damping over its inertia; its torque is one sample old (block 1/z, Fig. 4-2).
"""

from typing import NamedTuple

import numba
import numpy as np

from .motion import SAMPLE_TIME, Array

PD, TASK_SPACE, COMPUTED_TORQUE = 0, 1, 2


class Controller(NamedTuple):
    """Gains of the translation and rotation mode; nominal modal inertia and damping for (4.35)."""

    kind: int
    kp: tuple[float, float]  # Nm/rad, or 1/s^2 for computed torque
    kd: tuple[float, float]  # Nm s/rad, or 1/s for computed torque
    cutoff: float  # N, rad/s
    pole: float = -600.0  # of the observer, rad/s
    compensation: float = 0.4  # c
    inertia: tuple[float, float] = (0.7515e-3, 4.5109e-3)  # e1, e2: eigenvalues of M (5.2), kg m^2
    damping: tuple[float, float] = (0.00694, 0.004148)  # g1, g2: eigenvalues of D, N m s/rad


@numba.njit(cache=True)
def torque(
    c: Controller, error: Array, measured: Array, acceleration: Array, state: Array
) -> Array:
    """Commanded torque of one mode pair; ``state`` (2 modes x [filter, observer, last torque])."""
    out = np.empty(2)
    for i in range(2):
        held = np.exp(-c.cutoff * SAMPLE_TIME)
        derivative = c.cutoff * (error[i] - state[i, 0])
        state[i, 0] = held * state[i, 0] + (1.0 - held) * error[i]
        out[i] = c.kp[i] * error[i] + c.kd[i] * derivative
        if c.kind == COMPUTED_TORQUE:
            h = c.damping[i] / c.inertia[i]
            gain = -c.pole / h - 1.0
            rate = h * (state[i, 1] + gain * measured[i])
            out[i] = (
                c.inertia[i] * (acceleration[i] + out[i]) + c.compensation * c.damping[i] * rate
            )
            decay = np.exp(c.pole * SAMPLE_TIME)
            drive = c.pole * gain * measured[i] + state[i, 2] / (c.inertia[i] * h)
            state[i, 1] = decay * state[i, 1] + (decay - 1.0) / c.pole * drive
            state[i, 2] = out[i]
    return out
