r"""Compiled prediction of a closed chain whose axes are driven through gears, in the motors' coordinates.

.. math:: (M + \textstyle\sum_p w_p I_p(q))\,\ddot\theta + \sum_p w_p (\dot\theta^T H_p(q)\,\dot\theta + g_p(q)) + f = \tau

M and the friction f are those of a ``drive``; the machine's parts p add tables of inertia, velocity and gravity terms
along the *measured* motion: the posture is known to an encoder step, so that no kinematics is left in the loop, and
one kernel serves every machine. The tables hold over a sample by their mean; an error of second order in it.
"""

from typing import Any, NamedTuple

import numpy as np

from . import compilation, drive, drive_kernels
from .drive import Drive


class Tables(NamedTuple):
    """Terms of the parts of a machine at every sample, on the motors' shafts."""

    inertia: Any  # I (samples, parts, n, n) [kg m^2]
    velocity: Any  # H (samples, parts, n, n, n), of torque i, rates j and k [N m s^2/rad^2]
    gravity: Any  # g (samples, parts, n) [N m]


@compilation.kernel
def predict(
    position: Any,
    command: Any,
    tables: Tables,
    weights: Any,
    inertia: Any,
    plant: Drive,
    dt: float,
    substeps: int,
    bandwidth: float,
    residual: Any,
) -> None:
    """As ``drive_kernels.predict``, with the parts' ``weights`` (parts,) and M ``inertia`` (shafts, shafts).

    The machine hangs on the last n shafts: behind the couplings, where a drive has any.
    """
    samples, n = position.shape
    shafts = plant.shaft.shape[0]
    first = shafts - n
    alpha, beta = drive_kernels.correction_gains(bandwidth, dt)
    own = Drive(
        np.zeros((shafts, shafts)),
        plant.elements,
        plant.element,
        plant.shaft.copy(),
        plant.coupling,
    )
    q = np.zeros(shafts)
    for j in range(shafts):
        q[j] = position[0, j % n]
    v, z, held, lag, torque = drive_kernels.rest(plant, n)
    middle, before = np.zeros(n), np.zeros(shafts)
    work = drive.work_arrays(shafts)
    for k in range(samples):
        for j in range(n):
            residual[k, j] = position[k, j] - q[j]
        for j in range(shafts):
            q[j] += alpha * residual[k, j % n]
            v[j] += beta * residual[k, j % n]
            before[j] = v[j]
        after = min(k + 1, samples - 1)
        matrix = inertia.copy()
        for i in range(n):
            load = 0.0
            for p in range(weights.size):
                half = 0.5 * weights[p]
                load += half * (tables.gravity[k, p, i] + tables.gravity[after, p, i])
                for j in range(n):
                    matrix[first + i, first + j] += half * (
                        tables.inertia[k, p, i, j] + tables.inertia[after, p, i, j]
                    )
                    rate = v[first + j] + middle[j]
                    for m in range(n):
                        h = tables.velocity[k, p, i, j, m] + tables.velocity[after, p, i, j, m]
                        load += half * h * rate * (v[first + m] + middle[m])
            own.shaft[first + i, drive.BIAS] = plant.shaft[first + i, drive.BIAS] + load
        own.inertia_inverse[:, :] = np.linalg.inv(matrix)
        drive_kernels.advance(k, q, v, z, held, lag, torque, command, own, dt, substeps, work)
        for j in range(n):
            middle[j] = 0.5 * (v[first + j] - before[first + j])
