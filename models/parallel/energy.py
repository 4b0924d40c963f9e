r"""Energy equivalence: equations of motion of a closed chain from its bodies (Roldan, eq. 3.37).

.. math:: f = \sum_b J_b^T (M_b \ddot q_b + g_b), \qquad \ddot q_b = J_b \ddot q + \dot J_b \dot q

so that :math:`I = \sum J_b^T M_b J_b,\ C = \sum J_b^T M_b \dot J_b \dot q,\ G = \sum J_b^T g_b`. The velocity term
has :math:`M_b \dot J_b`, as in (4.20); (4.4) and (4.6) are misprinted. Planar bodies only: mass, moment of
inertia about the centre of mass, rows (x, y, angle). Rigid, without friction. Leading axes are a batch.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import kernels

Floats = NDArray[np.float64]


class Motion(NamedTuple):
    """Motion of all bodies' centres in the actuated coordinates; drift is Jdot times the rates."""

    jacobian: Floats  # (..., bodies, 3, n), rows x [m], y [m], angle [rad]
    drift: Floats  # (..., bodies, 3) [m/s^2, m/s^2, rad/s^2]


class Equations(NamedTuple):
    """f = inertia a + velocity + gravity."""

    inertia: Floats  # I (..., n, n)
    velocity: Floats  # C (..., n)
    gravity: Floats  # G (..., n)

    def force(self, acceleration: ArrayLike) -> Floats:
        """Actuator forces (..., n) that produce the accelerations (..., n)."""
        a = np.asarray(acceleration, dtype=float)
        inertial = np.einsum("...ij,...j->...i", self.inertia, a)
        return np.asarray(inertial + self.velocity + self.gravity)

    def acceleration(self, force: ArrayLike) -> Floats:
        """Accelerations (..., n) under actuator forces (..., n)."""
        net = np.asarray(force, dtype=float) - self.velocity - self.gravity
        return np.asarray(np.linalg.solve(self.inertia, net[..., None])[..., 0])


def equations(motion: Motion, mass: ArrayLike, inertia: ArrayLike, weight: float) -> Equations:
    """Equations (3.37) of bodies with masses [kg] and inertias [kg m^2] (bodies,); gravity along -y [m/s^2]."""
    m, i = np.asarray(mass, dtype=float), np.asarray(inertia, dtype=float)
    diagonal = np.stack([m, m, i], axis=-1)
    pulled = np.stack([0.0 * m, m * weight, 0.0 * m], axis=-1)
    j = motion.jacobian
    batch, n = j.shape[:-3], j.shape[-1]
    result = Equations(np.empty((*batch, n, n)), np.empty((*batch, n)), np.empty((*batch, n)))
    kernels.project_all(
        np.ascontiguousarray(j).reshape(-1, *j.shape[-3:]),
        np.ascontiguousarray(motion.drift).reshape(-1, *j.shape[-3:-1]),
        diagonal,
        pulled,
        result.inertia.reshape(-1, n, n),
        result.velocity.reshape(-1, n),
        result.gravity.reshape(-1, n),
    )
    return result


def regressor(motion: Motion, acceleration: ArrayLike, weight: float) -> Floats:
    """K (..., n, 2 bodies) of f = K (m_1 .. m_B, I_1 .. I_B), eqs. (6.5)-(6.8)."""
    j, a = motion.jacobian, np.asarray(acceleration, dtype=float)
    second = np.einsum("...bki,...i->...bk", j, a) + motion.drift
    second = second + np.array([0.0, weight, 0.0])
    by_mass = np.einsum("...bki,...bk->...ib", j[..., :2, :], second[..., :2])
    by_inertia = np.einsum("...bi,...b->...ib", j[..., 2, :], second[..., 2])
    return np.concatenate([by_mass, by_inertia], axis=-1)
