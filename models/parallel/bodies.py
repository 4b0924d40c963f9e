r"""Regressor of any closed chain in the ten inertial parameters of each body.

In a body's own axes, with the acceleration a of its origin, gravity g, angular velocity w, first moment
:math:`h = m c` and the tensor I about the origin (not the centre of mass):

1. force    :math:`m (a - g) + \dot w \times h + w \times (w \times h)`
2. moment   :math:`h \times (a - g) + I \dot w + w \times I w`

Linear in (m, h, I) and projected by (3.37) of Roldan. For machines without a closed form; see ``energy`` for those
whose centres of mass are known.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .rotation import ENTRIES, inertia_tensor, tensor_columns

Floats = NDArray[np.float64]

PARAMETERS = ("m", "mx", "my", "mz", "Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz")


class BodyMotion(NamedTuple):
    """Motion of bodies' origins in their own axes; drift is the acceleration at zero driven acceleration."""

    jacobian: Floats  # (..., bodies, 6, n), rows x, y, z [m], w [rad]
    drift: Floats  # (..., bodies, 6) [m/s^2, rad/s^2]
    spin: Floats  # w (..., bodies, 3) [rad/s]
    gravity: Floats  # (..., bodies, 3) [m/s^2]


def regressor(motion: BodyMotion, acceleration: ArrayLike) -> Floats:
    """K (..., n, 10 bodies) of f = K parameters, PARAMETERS of the first body first."""
    a = np.asarray(acceleration, dtype=float)
    second = np.einsum("...bki,...i->...bk", motion.jacobian, a) + motion.drift
    linear, turn, w = second[..., :3] - motion.gravity, second[..., 3:], motion.spin
    columns = np.zeros((*w.shape[:-1], 6, 10))
    columns[..., :3, 0] = linear
    columns[..., :3, 1:4] = cross_matrix(turn) + cross_matrix(w) @ cross_matrix(w)
    columns[..., 3:, 1:4] = -cross_matrix(linear)
    columns[..., 3:, 4:] = tensor_columns(w, turn)
    pulled = np.einsum("...bki,...bkp->...ibp", motion.jacobian, columns)
    return pulled.reshape(*pulled.shape[:-2], -1)


def parameters(mass: float, centre: ArrayLike, inertia: ArrayLike) -> Floats:
    """Ten parameters (10,) of a body from its mass, centre (3,) and tensor entries (6,) about the centre."""
    c = np.asarray(centre, dtype=float)
    about_origin = inertia_tensor(inertia) + mass * (c @ c * np.eye(3) - np.outer(c, c))
    entries = [about_origin[i, j] for i, j in ENTRIES]
    return np.array([mass, *(mass * c), *entries])


def central(values: ArrayLike) -> tuple[float, Floats, Floats]:
    """Mass, centre (3,) and tensor entries (6,) about it: the inverse of ``parameters``."""
    p = np.asarray(values, dtype=float)
    mass = float(p[0])
    c = p[1:4] / mass if mass > 0.0 else np.zeros(3)
    about_centre = inertia_tensor(p[4:]) - mass * (c @ c * np.eye(3) - np.outer(c, c))
    return mass, c, np.array([about_centre[i, j] for i, j in ENTRIES])


def cross_matrix(vector: ArrayLike) -> Floats:
    """Matrix (..., 3, 3) of the product vector x."""
    x, y, z = np.moveaxis(np.asarray(vector, dtype=float), -1, 0)
    zero = 0.0 * x
    rows = [(zero, -z, y), (z, zero, -x), (-y, x, zero)]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
