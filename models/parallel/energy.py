r"""Energy equivalence: equations of motion of a closed chain from its bodies (Roldan, eq. 3.37).

.. math:: f = \sum_b J_b^T (M_b \ddot q_b + c_b + g_b), \qquad \ddot q_b = J_b \ddot q + \dot J_b \dot q

so that :math:`I = \sum J_b^T M_b J_b,\ C = \sum J_b^T (M_b \dot J_b \dot q + c_b),\ G = \sum J_b^T g_b`. The velocity
term has :math:`M_b \dot J_b`, as in (4.20); (4.4) and (4.6) are misprinted. Planar bodies have rows (x, y, angle)
and :math:`c_b = 0`; spatial ones have rows (x, y, z, w), with the angular velocity w in the body's own axes, whose
:math:`c_b = w \times I w` is the Boltzmann-Hamel term (3.64). Rigid, without friction. Leading axes are a batch.
"""

from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import kernels
from .rotation import body_moment, inertia_tensor, tensor_columns

Floats = NDArray[np.float64]


class Motion(NamedTuple):
    """Motion of planar bodies' centres in the actuated coordinates; drift is Jdot times the rates."""

    jacobian: Floats  # (..., bodies, 3, n), rows x [m], y [m], angle [rad]
    drift: Floats  # (..., bodies, 3) [m/s^2, m/s^2, rad/s^2]


class SpatialMotion(NamedTuple):
    """Motion of spatial bodies' centres (world axes) and angular velocities (axes of each body)."""

    jacobian: Floats  # (..., bodies, 6, n), rows x, y, z [m], w [rad]
    drift: Floats  # (..., bodies, 6) [m/s^2, rad/s^2]
    spin: Floats  # w (..., bodies, 3) [rad/s]


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
    return _project(motion.jacobian, motion.drift, diagonal, pulled)


def spatial_equations(
    motion: SpatialMotion, mass: ArrayLike, inertia: ArrayLike, weight: float
) -> Equations:
    """As ``equations``; inertias (bodies, 6) xx, yy, zz, xy, xz, yz in each body's axes; gravity along -z."""
    m = np.asarray(mass, dtype=float)
    moments, into = _principal(np.ascontiguousarray(inertia, dtype=float).tobytes())
    j, drift = motion.jacobian.copy(), motion.drift.copy()
    j[..., 3:, :] = into @ j[..., 3:, :]
    drift[..., 3:] = np.einsum("bij,...bj->...bi", into, drift[..., 3:])
    spin = np.einsum("bij,...bj->...bi", into, motion.spin)
    diagonal = np.concatenate([np.repeat(m[:, None], 3, axis=1), moments], axis=1)
    pulled = np.zeros((m.size, 6))
    pulled[:, 2] = m * weight
    found = _project(j, drift, diagonal, pulled)
    turning = body_moment(spin, np.zeros(3), moments[:, :, None] * np.eye(3))
    gyroscopic = np.einsum("...bki,...bk->...i", j[..., 3:, :], turning)
    return found._replace(velocity=found.velocity + gyroscopic)


@lru_cache(maxsize=64)
def _principal(inertia: bytes) -> tuple[Floats, Floats]:
    """Moments (bodies, 3) and rotations (bodies, 3, 3) into principal axes, in which the mass matrix is diagonal."""
    moments, axes = np.linalg.eigh(inertia_tensor(np.frombuffer(inertia).reshape(-1, 6)))
    into = np.swapaxes(axes, -1, -2)
    moments.flags.writeable = into.flags.writeable = False
    return moments, into


def regressor(motion: Motion, acceleration: ArrayLike, weight: float) -> Floats:
    """K (..., n, 2 bodies) of f = K (m_1 .. m_B, I_1 .. I_B), eqs. (6.5)-(6.8)."""
    j, second = motion.jacobian, _second(motion, acceleration)
    second = second + np.array([0.0, weight, 0.0])
    by_mass = np.einsum("...bki,...bk->...ib", j[..., :2, :], second[..., :2])
    by_inertia = np.einsum("...bi,...b->...ib", j[..., 2, :], second[..., 2])
    return np.concatenate([by_mass, by_inertia], axis=-1)


def spatial_regressor(motion: SpatialMotion, acceleration: ArrayLike, weight: float) -> Floats:
    """K (..., n, 7 bodies) of f = K (m_1 .. m_B, then xx, yy, zz, xy, xz, yz of each body)."""
    j, second = motion.jacobian, _second(motion, acceleration)
    linear = second[..., :3] + np.array([0.0, 0.0, weight])
    by_mass = np.einsum("...bki,...bk->...ib", j[..., :3, :], linear)
    columns = tensor_columns(motion.spin, second[..., 3:])
    by_inertia = np.einsum("...bki,...bkp->...ibp", j[..., 3:, :], columns)
    flat = by_inertia.reshape(*by_inertia.shape[:-2], -1)
    return np.concatenate([by_mass, flat], axis=-1)


def _second(motion: Motion | SpatialMotion, acceleration: ArrayLike) -> Floats:
    a = np.asarray(acceleration, dtype=float)
    return np.asarray(np.einsum("...bki,...i->...bk", motion.jacobian, a) + motion.drift)


def _project(jacobian: Floats, drift: Floats, diagonal: Floats, pulled: Floats) -> Equations:
    """Sum (3.37) over bodies with diagonal masses and pulls (bodies, rows), for a batch."""
    batch, n = jacobian.shape[:-3], jacobian.shape[-1]
    result = Equations(np.empty((*batch, n, n)), np.empty((*batch, n)), np.empty((*batch, n)))
    kernels.project_all(
        np.ascontiguousarray(jacobian).reshape(-1, *jacobian.shape[-3:]),
        np.ascontiguousarray(drift).reshape(-1, *jacobian.shape[-3:-1]),
        diagonal,
        pulled,
        result.inertia.reshape(-1, n, n),
        result.velocity.reshape(-1, n),
        result.gravity.reshape(-1, n),
    )
    return result
