r"""Kinematics of the MM3A in the Denavit-Hartenberg frames of Table A.1 (Damani 2013, appendix A.1-A.2).

With :math:`L = l_2 + q_3` and :math:`\rho = a_1 - L s_2`, tip position and motion in frame 0 are

1. :math:`p = (\rho c_1, \rho s_1, L c_2)`                                     (A.2)
2. :math:`(\dot p, \omega) = J(q)\,\dot q`                                     (A.3)
3. :math:`q_1 = \mathrm{atan2}(p_y, p_x)`                                      (A.4)
4. :math:`q_2 = \mathrm{atan2}(a_1 - \rho, p_z)`, :math:`L^2 = (a_1 - \rho)^2 + p_z^2`

(4) replaces (A.6) and (A.8). (A.6) is off by a quarter turn for these frames, and (A.8) repeats
with a choice of sign what the sides of one triangle give. (A.4) finds only the postures that reach
forward (:math:`\rho > 0`); the same point is also reached backward with :math:`q_1 + \pi` and
:math:`-\rho`, which these joint ranges allow. Angles in rad, lengths in m. A point on the axis of joint 1
leaves :math:`q_1` free: 0 is returned.
"""

from typing import Any

import numpy as np

Vector = tuple[Any, Any, Any]
TURN = 2.0 * np.pi


def tip(q: Any, arm: Any) -> Vector:
    """Tip position (1) in frame 0 [m] at joints ``q`` = (q1, q2, q3)."""
    length = arm.forearm + q[2]
    reach = arm.shoulder - length * np.sin(q[1])
    return reach * np.cos(q[0]), reach * np.sin(q[0]), length * np.cos(q[1])


def tip_axes(q: Any) -> tuple[Vector, Vector, Vector]:
    """Rows of R_03, the orientation of the tip frame in frame 0 (A.1)."""
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    return (c1 * c2, -s1, -c1 * s2), (s1 * c2, c1, -s1 * s2), (s2, 0.0 * s2, c2)


def jacobian(q: Any, arm: Any) -> tuple[Vector, Vector, Vector]:
    """Rows of the translational Jacobian (2) in frame 0: tip velocity [m/s] per joint rate."""
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    length = arm.forearm + q[2]
    reach = arm.shoulder - length * s2
    return (
        (-reach * s1, -length * c1 * c2, -c1 * s2),
        (reach * c1, -length * s1 * c2, -s1 * s2),
        (0.0 * reach, -length * s2, c2),
    )


def rotation_jacobian(q: Any) -> tuple[Vector, Vector, Vector]:
    """Rows of the rotational Jacobian (2) in frame 0: angular velocity [rad/s] per joint rate."""
    c1, s1 = np.cos(q[0]), np.sin(q[0])
    return (0.0, s1, 0.0), (0.0, -c1, 0.0), (1.0, 0.0, 0.0)


def inverse(point: Any, arm: Any, backward: bool = False) -> Vector:
    """Joints (3, 4) that bring the tip to ``point`` in frame 0, reaching forward or backward.

    q1 is in (-pi, pi], q2 in (upper_2 - 2 pi, upper_2], where the range of joint 2 lies. Limits are not
    checked: see ``solutions``.
    """
    x, y, z = point
    reach = np.sqrt(x * x + y * y)
    q1 = np.arctan2(y, x)
    if backward:
        reach = -reach
        q1 = q1 - np.pi if q1 > 0.0 else q1 + np.pi
    across = arm.shoulder - reach
    q2 = np.arctan2(across, z)
    if q2 > arm.upper_2:
        q2 = q2 - TURN
    return q1, q2, np.sqrt(across * across + z * z) - arm.forearm


def within_limits(q: Any, arm: Any) -> bool:
    """Whether every joint is inside its range."""
    return bool(
        arm.lower_1 <= q[0] <= arm.upper_1
        and arm.lower_2 <= q[1] <= arm.upper_2
        and arm.lower_3 <= q[2] <= arm.upper_3
    )


def solutions(point: Any, arm: Any) -> list[Vector]:
    """Every posture inside the joint limits that reaches ``point`` in frame 0, forward first."""
    both = (inverse(point, arm, False), inverse(point, arm, True))
    return [q for q in both if within_limits(q, arm)]
