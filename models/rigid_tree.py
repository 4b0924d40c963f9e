r"""Rigid bodies in a fixed-base tree: joint efforts linear in the standard inertial parameters.

.. math:: \tau = Y(q, \dot q, \ddot q, g)\,\varphi, \qquad
          f_i = m a_i + (\dot\omega^\times + \omega^\times\omega^\times) m c, \quad
          n_i = mc \times a_i + I\dot\omega + \omega\times I\omega

:math:`\varphi` (10 B,) holds m, mc (3), Ixx, Ixy, Ixz, Iyy, Iyz, Izz of every body about its own origin
and in its own frame, :math:`a_i` is the acceleration of that origin less gravity. Every body hangs on one
revolute, prismatic or fixed joint, parents stand before their children. Source: Khalil and Dombre 2002,
ch. 9. Not modelled here: closed loops, joints of several degrees of freedom, rotors.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

FIXED, REVOLUTE, PRISMATIC = range(3)
PARAMETERS = 10  # standard inertial parameters of a body


class Tree(NamedTuple):
    """Bodies and joints of a tree; X_PF is the joint's frame on the parent, X_MB the body's on it."""

    parent: NDArray[np.int64]  # (B,) number of the parent body, -1 for the world
    joint: NDArray[np.int64]  # (B,) FIXED, REVOLUTE or PRISMATIC
    column: NDArray[np.int64]  # (B,) index of the joint's position in q, -1 for fixed joints
    axis: Array  # (B, 3) of the joint, in F
    R_PF: Array  # (B, 3, 3)
    p_PF: Array  # (B, 3)
    R_MB: Array  # (B, 3, 3)
    p_MB: Array  # (B, 3)


def rotation(axis: Any, angle: Any, out: Any) -> None:
    """Rotation matrix about a unit axis (Rodrigues), written to ``out`` (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    x, y, z = axis[0], axis[1], axis[2]
    out[0, 0], out[0, 1], out[0, 2] = (
        c + x * x * (1 - c),
        x * y * (1 - c) - z * s,
        x * z * (1 - c) + y * s,
    )
    out[1, 0], out[1, 1], out[1, 2] = (
        y * x * (1 - c) + z * s,
        c + y * y * (1 - c),
        y * z * (1 - c) - x * s,
    )
    out[2, 0], out[2, 1], out[2, 2] = (
        z * x * (1 - c) - y * s,
        z * y * (1 - c) + x * s,
        c + z * z * (1 - c),
    )


def cross(a: Any, b: Any) -> Any:
    """Vector product as a tuple."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def times(A: Any, x: Any) -> Any:
    """Product of a matrix (3, 3) and a vector (3,) as a tuple."""
    return (
        A[0, 0] * x[0] + A[0, 1] * x[1] + A[0, 2] * x[2],
        A[1, 0] * x[0] + A[1, 1] * x[1] + A[1, 2] * x[2],
        A[2, 0] * x[0] + A[2, 1] * x[1] + A[2, 2] * x[2],
    )


def transposed_times(A: Any, x: Any) -> Any:
    """Product of the transpose of a matrix (3, 3) and a vector (3,) as a tuple."""
    return (
        A[0, 0] * x[0] + A[1, 0] * x[1] + A[2, 0] * x[2],
        A[0, 1] * x[0] + A[1, 1] * x[1] + A[2, 1] * x[2],
        A[0, 2] * x[0] + A[1, 2] * x[1] + A[2, 2] * x[2],
    )


def product(A: Any, B: Any, out: Any) -> None:
    """Product of two matrices (3, 3), written to ``out``, which is neither of them."""
    for i in range(3):
        for j in range(3):
            out[i, j] = A[i, 0] * B[0, j] + A[i, 1] * B[1, j] + A[i, 2] * B[2, j]


def unit_inertia_times(i: int, j: int, w: Any) -> Any:
    """I w as a tuple, where I has nothing but I_ij = I_ji = 1."""
    first, second = w[j], w[i] if i != j else 0.0
    return (
        (first if i == 0 else 0.0) + (second if j == 0 else 0.0),
        (first if i == 1 else 0.0) + (second if j == 1 else 0.0),
        (first if i == 2 else 0.0) + (second if j == 2 else 0.0),
    )


def wrenches(w: Any, dw: Any, a: Any, force: Any, moment: Any) -> None:
    """Force and moment about the origin per inertial parameter, (10, 3) each, in the body's frame.

    ``w`` and ``dw`` are angular velocity and acceleration, ``a`` the acceleration of the origin less
    gravity, all (3,) in the body's frame.
    """
    force[:] = 0.0
    moment[:] = 0.0
    for i in range(3):
        force[0, i] = a[i]
        e = (1.0 if i == 0 else 0.0, 1.0 if i == 1 else 0.0, 1.0 if i == 2 else 0.0)
        turned = cross(w, cross(w, e))
        spun = cross(dw, e)
        lever = cross(e, a)
        for k in range(3):
            force[1 + i, k] = spun[k] + turned[k]
            moment[1 + i, k] = lever[k]
    number = 4
    for i in range(3):
        for j in range(i, 3):
            dh = unit_inertia_times(i, j, dw)
            gyro = cross(w, unit_inertia_times(i, j, w))
            for k in range(3):
                moment[number, k] = dh[k] + gyro[k]
            number += 1


def standard_parameters(mass: float, com: Array, inertia_about_origin: Array) -> Array:
    """The ten parameters of a body from mass [kg], centre of mass (3,) [m], inertia (3, 3) [kg m^2]."""
    upper = inertia_about_origin[np.triu_indices(3)]
    return np.concatenate([[mass], mass * np.asarray(com), upper])


def point_mass(place: Array) -> Array:
    """The ten parameters of 1 kg at a place (3,) [m]."""
    p = np.asarray(place, dtype=float)
    return standard_parameters(1.0, p, float(p @ p) * np.eye(3) - np.outer(p, p))
