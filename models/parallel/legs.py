r"""Three P-R-S legs at one posture, for compiled loops: the equations (1)-(3) of ``prs``.

Results are written to the arrays at the end of the arguments. Lengths in m, angles in rad; vectors in world axes.
NaN out of reach and at singular postures.
"""

from typing import Any, NamedTuple

import numpy as np


class Legs(NamedTuple):
    """Geometry of a table as arrays, see ``prs.Table``."""

    radial: Any  # e_i (3, 3)
    along: Any  # d_i (3, 3)
    across: Any  # t_i (3, 3)
    share: Any  # (3,) combination of the leg planes that x and y drop out of
    solved: Any  # (2, 3) x and y by what the planes lack
    start: float
    bar: float
    radius: float
    centre: Any  # (3,) of mass of the platform, in its frame


def platform_rows(psi: Any, theta: Any, phi: Any) -> Any:
    """Rows of R = R_y(theta) R_x(psi) R_z(phi), platform to world (3.42), of floats or arrays."""
    s1, s2, s3 = np.sin(psi), np.sin(theta), np.sin(phi)
    c1, c2, c3 = np.cos(psi), np.cos(theta), np.cos(phi)
    return (
        (c2 * c3 + s1 * s2 * s3, -c2 * s3 + s1 * s2 * c3, c1 * s2),
        (c1 * s3, c1 * c3, -s1),
        (-s2 * c3 + s1 * c2 * s3, s2 * s3 + s1 * c2 * c3, c1 * c2),
    )


def platform_rate_rows(psi: Any, phi: Any) -> Any:
    """Rows from the rates of (psi, theta, phi) to w in the platform's axes, of floats or arrays.

    At phi = 0 the first two columns are (B.57): w = (psi', cos(psi) theta', -sin(psi) theta').
    """
    zero = 0.0 * phi
    return (
        (np.cos(phi), np.sin(phi) * np.cos(psi), zero),
        (-np.sin(phi), np.cos(phi) * np.cos(psi), zero),
        (zero, -np.sin(psi) + zero, zero + 1.0),
    )


def fill(rows: Any, out: Any) -> None:
    """Write three rows of three into ``out`` (3, 3)."""
    for i in range(3):
        out[i, 0], out[i, 1], out[i, 2] = rows[i]


def cross(a: Any, b: Any) -> Any:
    """Product a x b of two vectors (3,)."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


def dot(a: Any, b: Any) -> Any:
    """Product of two vectors (3,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def solve(left: Any, right: Any) -> None:
    """Solve left x = right (n, n), (n, m) in place by elimination with pivots; NaN where singular."""
    n, m = right.shape
    for c in range(n):
        best = c
        for r in range(c + 1, n):
            if np.abs(left[r, c]) > np.abs(left[best, c]):
                best = r
        if not np.abs(left[best, c]) > 0.0 or not np.abs(left[best, c]) < np.inf:
            right[:, :] = np.nan
            return
        for j in range(n):
            left[c, j], left[best, j] = left[best, j], left[c, j]
        for j in range(m):
            right[c, j], right[best, j] = right[best, j], right[c, j]
        for r in range(c + 1, n):
            factor = left[r, c] / left[c, c]
            for j in range(c, n):
                left[r, j] -= factor * left[c, j]
            for j in range(m):
                right[r, j] -= factor * right[c, j]
    for c in range(n - 1, -1, -1):
        for j in range(m):
            for k in range(c + 1, n):
                right[c, j] -= left[c, k] * right[k, j]
            right[c, j] /= left[c, c]


def pose(task: Any, legs: Legs, position: Any, turned: Any, joints: Any) -> Any:
    """Position (3,), R (3, 3) and joints B_i (3, 3) at tasks (z, psi, theta) (2); returns phi."""
    fill(platform_rows(task[1], task[2], 0.0), turned)
    a, b = 0.0, 0.0
    for k in range(3):
        for i in range(3):
            weight = legs.share[k] * legs.radius * legs.across[k, i]
            a += weight * dot(turned[i], legs.radial[k])
            b += weight * dot(turned[i], legs.across[k])
    phi = np.arctan(-a / b)
    fill(platform_rows(task[1], task[2], phi), turned)
    position[0], position[1], position[2] = 0.0, 0.0, task[0]
    for k in range(3):
        for i in range(3):
            joints[k, i] = legs.radius * dot(turned[i], legs.radial[k])
        off = dot(legs.across[k], joints[k])
        position[0] += legs.solved[0, k] * off
        position[1] += legs.solved[1, k] * off
    for k in range(3):
        for i in range(3):
            joints[k, i] += position[i]
    return phi


def sliders(joints: Any, legs: Legs, modes: Any, out: Any) -> None:
    """Slider positions (3,) that reach the joints (3, 3) (20)."""
    for k in range(3):
        ahead, square = 0.0, 0.0
        for i in range(3):
            reach = joints[k, i] - legs.start * legs.radial[k, i]
            ahead += legs.along[k, i] * reach
            square += reach * reach
        out[k] = ahead + modes[k] * np.sqrt(ahead * ahead - square + legs.bar * legs.bar)


def bars(joints: Any, q: Any, legs: Legs, out: Any) -> None:
    """Vectors l_i (3, 3) from slider to joint (1)."""
    for k in range(3):
        for i in range(3):
            out[k, i] = joints[k, i] - legs.start * legs.radial[k, i] - q[k] * legs.along[k, i]


def constraints(position: Any, joints: Any, rods: Any, legs: Legs, left: Any, right: Any) -> None:
    """Both sides (6, 6), (6, 3) of (3), the first three rows divided by the bar's length."""
    for k in range(3):
        arm = (joints[k, 0] - position[0], joints[k, 1] - position[1], joints[k, 2] - position[2])
        row = (rods[k, 0] / legs.bar, rods[k, 1] / legs.bar, rods[k, 2] / legs.bar)
        turning, sideways = cross(arm, row), cross(arm, legs.across[k])
        for i in range(3):
            left[k, i], left[k, 3 + i] = row[i], turning[i]
            left[3 + k, i], left[3 + k, 3 + i] = legs.across[k, i], sideways[i]
            right[k, i], right[3 + k, i] = 0.0, 0.0
        right[k, k] = dot(row, legs.along[k])


def task_rates(turned: Any, twist: Any, psi: Any, phi: Any, rates: Any, out: Any) -> None:
    """Rates of (z, psi, theta) per slider rate (3, 3) from the platform's twist (6, 3); ``rates`` (3, 3) is scratch."""
    fill(platform_rate_rows(psi, phi), rates)
    for i in range(3):
        for c in range(3):
            out[i, c] = 0.0
            for j in range(3):
                out[i, c] += turned[j, i] * twist[3 + j, c]
    solve(rates, out)
    for c in range(3):
        out[2, c] = out[1, c]
        out[1, c] = out[0, c]
        out[0, c] = twist[2, c]


def point_rate(twist: Any, c: int, arm: Any) -> Any:
    """Velocity of a point at ``arm`` (3,) from the platform's origin, by column ``c`` of twists (6, n)."""
    turning = cross((twist[3, c], twist[4, c], twist[5, c]), arm)
    return twist[0, c] + turning[0], twist[1, c] + turning[1], twist[2, c] + turning[2]


def bar_motion(
    k: int,
    rods: Any,
    normal: Any,
    rows: Any,
    turn: Any,
    bias: Any,
    legs: Legs,
    jacobian: Any,
    drift: Any,
) -> None:
    """Jacobian (6, 3) and drift (6,) of bar ``k``, which turns by ``rows`` (3,) and ``bias`` about its revolute axis."""
    for i in range(3):
        for c in range(3):
            slide = legs.along[k, i] if c == k else 0.0
            jacobian[i, c] = slide + 0.5 * normal[i] * rows[c]
        drift[i] = 0.5 * normal[i] * bias - 0.5 * rods[k, i] * turn * turn
    for c in range(3):
        jacobian[3, c] = rows[c]
    drift[3] = bias


def platform_motion(
    turned: Any, twist: Any, bias: Any, spin: Any, legs: Legs, jacobian: Any, drift: Any, own: Any
) -> None:
    """Jacobian (6, 3), drift (6,) and spin ``own`` (3,) of the platform from its twist (6, 3) and bias (6, 1)."""
    arm = (dot(turned[0], legs.centre), dot(turned[1], legs.centre), dot(turned[2], legs.centre))
    inward = cross(spin, cross(spin, arm))
    outward = point_rate(bias, 0, arm)
    for i in range(3):
        drift[i] = outward[i] + inward[i]
        drift[3 + i] = own[i] = 0.0
        for j in range(3):
            drift[3 + i] += turned[j, i] * bias[3 + j, 0]
            own[i] += turned[j, i] * spin[j]
    for c in range(3):
        rate = point_rate(twist, c, arm)
        for i in range(3):
            jacobian[i, c] = rate[i]
            jacobian[3 + i, c] = 0.0
            for j in range(3):
                jacobian[3 + i, c] += turned[j, i] * twist[3 + j, c]
