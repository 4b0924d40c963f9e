r"""Rotation of a body: angles of the tables, Euler angles, and the Boltzmann-Hamel equations (Roldan, 3.42-3.70).

1. orientation of a platform      :math:`R = R_y(\theta) R_x(\psi) R_z(\phi)` (3.42)
2. quasi-velocities               :math:`w = D^T \dot q_e` (3.44), Euler angles (nutation, precession, spin), z-x-z
3. in Euler angles                :math:`\tau_e = D I \dot w + 2 \dot D I w - A^T I w,\ A = \partial \dot w / \partial \dot q_e`
4. in the body's axes             :math:`m = D^{-1} \tau_e = I \dot w + w \times I w` (3.64)

Corrected here: (3.42), second row, second entry is cos(psi) cos(phi). (3.65) projects (3) with J_R^T; (3) is a force in
the Euler angles and takes their Jacobian J^T, as (3.70) has it. The machines use (4), which has no singular
orientation; (3) is kept as its witness. Leading axes are a batch.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .legs import platform_rate_rows, platform_rows

Floats = NDArray[np.float64]

# Places of xx, yy, zz, xy, xz, yz in a tensor.
ENTRIES = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))

PERMUTATIONS = np.zeros((3, 3, 3))  # of the cross product
for _i, _j, _k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
    PERMUTATIONS[_i, _j, _k], PERMUTATIONS[_i, _k, _j] = 1.0, -1.0


def cross(a: ArrayLike, b: ArrayLike) -> Floats:
    """Product a x b (..., 3) of vectors, for single ones in a tenth of the time of ``numpy.cross``."""
    left, right = np.asarray(a, dtype=float), np.asarray(b, dtype=float)
    return np.asarray(np.einsum("ijk,...j,...k->...i", PERMUTATIONS, left, right))


def platform(psi: ArrayLike, theta: ArrayLike, phi: ArrayLike) -> Floats:
    """R (..., 3, 3) of rotations psi, theta, phi [rad] about x, y, z, platform to world (3.42)."""
    rows = platform_rows(*(np.asarray(angle, dtype=float) for angle in (psi, theta, phi)))
    out = np.empty((*np.shape(rows[0][0]), 3, 3))
    for i, row in enumerate(rows):
        for j, entry in enumerate(row):
            out[..., i, j] = entry
    return out


def platform_rates(psi: ArrayLike, theta: ArrayLike, phi: ArrayLike) -> Floats:
    """Matrix (..., 3, 3) from the rates of (psi, theta, phi) to w in the platform's axes.

    At phi = 0 its first two columns are (B.57): w = (psi', cos(psi) theta', -sin(psi) theta').
    """
    psi, theta, phi = np.broadcast_arrays(*(np.asarray(a, dtype=float) for a in (psi, theta, phi)))
    out = np.empty((*phi.shape, 3, 3))
    for i, row in enumerate(platform_rate_rows(psi, phi)):
        for j, entry in enumerate(row):
            out[..., i, j] = entry
    return out


def inertia_tensor(entries: ArrayLike) -> Floats:
    """Symmetric tensors (..., 3, 3) from entries (..., 6) xx, yy, zz, xy, xz, yz."""
    e = np.asarray(entries, dtype=float)
    tensor = np.zeros((*e.shape[:-1], 3, 3))
    for k, (i, j) in enumerate(ENTRIES):
        tensor[..., i, j] = tensor[..., j, i] = e[..., k]
    return tensor


def body_moment(w: ArrayLike, acceleration: ArrayLike, tensor: ArrayLike) -> Floats:
    """Moment (..., 3) I w' + w x I w in the body's axes [N m] (3.64)."""
    spin, inertia = np.asarray(w, dtype=float), np.asarray(tensor, dtype=float)
    turned = np.einsum("...ij,...j->...i", inertia, np.asarray(acceleration, dtype=float))
    return np.asarray(turned + cross(spin, np.einsum("...ij,...j->...i", inertia, spin)))


def tensor_columns(w: ArrayLike, acceleration: ArrayLike) -> Floats:
    """Moment (3.64) per unit of each tensor entry: (..., 3, 6)."""
    units = inertia_tensor(np.eye(6))
    spin, turn = (np.asarray(v, dtype=float)[..., None, :] for v in (w, acceleration))
    return np.swapaxes(body_moment(spin, turn, units), -1, -2)


def euler_matrix(angles: ArrayLike) -> Floats:
    """D^T (..., 3, 3) of w = D^T q_e' at Euler angles (nutation, precession, spin) [rad] (3.44)."""
    nutation, _, spin = np.moveaxis(np.asarray(angles, dtype=float), -1, 0)
    zero = 0.0 * nutation
    rows = [
        (np.cos(spin), np.sin(nutation) * np.sin(spin), zero),
        (-np.sin(spin), np.sin(nutation) * np.cos(spin), zero),
        (zero, np.cos(nutation), zero + 1.0),
    ]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def euler_derivatives(angles: ArrayLike) -> Floats:
    """Derivatives (..., 3, 3, 3) of D^T by nutation, precession and spin (third axis from the end)."""
    nutation, _, spin = np.moveaxis(np.asarray(angles, dtype=float), -1, 0)
    out = np.zeros((*nutation.shape, 3, 3, 3))
    out[..., 0, 0, 1] = np.cos(nutation) * np.sin(spin)
    out[..., 0, 1, 1] = np.cos(nutation) * np.cos(spin)
    out[..., 0, 2, 1] = -np.sin(nutation)
    out[..., 2, 0, 0], out[..., 2, 0, 1] = -np.sin(spin), np.sin(nutation) * np.cos(spin)
    out[..., 2, 1, 0], out[..., 2, 1, 1] = -np.cos(spin), -np.sin(nutation) * np.sin(spin)
    return out


def euler_forces(
    angles: ArrayLike, rates: ArrayLike, accelerations: ArrayLike, tensor: ArrayLike
) -> Floats:
    """Boltzmann-Hamel (3.60), (3.66)-(3.70): generalised forces (..., 3) in the Euler angles [N m]."""
    u, a = np.asarray(rates, dtype=float), np.asarray(accelerations, dtype=float)
    inertia = np.asarray(tensor, dtype=float)
    into_w, by_angle = euler_matrix(angles), euler_derivatives(angles)
    dot = np.einsum("...kij,...k->...ij", by_angle, u)
    w = np.einsum("...ij,...j->...i", into_w, u)
    turn = np.einsum("...ij,...j->...i", dot, u) + np.einsum("...ij,...j->...i", into_w, a)
    # A = d w' / d q_e' is Ddot^T and what w changes with the angles.
    by_rate = dot + np.einsum("...kij,...j->...ik", by_angle, u)
    momentum = np.einsum("...ij,...j->...i", inertia, w)
    return np.asarray(
        np.einsum("...ji,...jk,...k->...i", into_w, inertia, turn)
        + 2.0 * np.einsum("...ji,...j->...i", dot, momentum)
        - np.einsum("...ji,...j->...i", by_rate, momentum)
    )
