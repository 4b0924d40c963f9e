r"""Kinematics of a five-bar for floats and for arrays of postures alike (Roldan, appendix B.1).

Angles count from +x; the cranks turn about (-H/2, 0) and (H/2, 0). Closing the loop at the joint C of both rods,
:math:`a + l_2 e(\alpha_2) = b + l_3 e(\alpha_3)`, and differentiating it twice gives the rods' rates and their
accelerations at constant crank rates (B.13-B.17).
"""

from typing import Any

import numpy as np


def apex(ax: Any, ay: Any, bx: Any, by: Any, from_a: Any, from_b: Any, side: Any) -> Any:
    """Point (x, y) at two distances from a and b, left (side +1) or right (-1) of the line from a to b.

    NaN where the circles do not meet. In place of (B.22), which is 1 + (...)^2.
    """
    dx, dy = bx - ax, by - ay
    square = dx * dx + dy * dy
    share = 0.5 * (from_a * from_a - from_b * from_b + square) / square
    height = side * np.sqrt(from_a * from_a / square - share * share)
    return ax + share * dx - height * dy, ay + share * dy + height * dx


def rod_angles(q1: Any, q4: Any, base: Any, l1: Any, l2: Any, l3: Any, l4: Any, mode: Any) -> Any:
    """Angles of both rods [rad] (B.18-B.27) at crank angles [rad]; the mode is the side of C."""
    ax, ay = l1 * np.cos(q1) - 0.5 * base, l1 * np.sin(q1)
    bx, by = l4 * np.cos(q4) + 0.5 * base, l4 * np.sin(q4)
    cx, cy = apex(ax, ay, bx, by, l2, l3, mode)
    return np.arctan2(cy - ay, cx - ax), np.arctan2(cy - by, cx - bx)


def rods(
    q1: Any, q4: Any, w1: Any, w4: Any, base: Any, l1: Any, l2: Any, l3: Any, l4: Any, mode: Any
) -> Any:
    """Angles of rods 2 and 3, their rates per crank rate, and their accelerations at constant rates.

    Order: angle2, angle3 [rad], d2/d1, d2/d4, d3/d1, d3/d4 [-], drift2, drift3 [rad/s^2].
    """
    two, three = rod_angles(q1, q4, base, l1, l2, l3, l4, mode)
    crossing = np.sin(three - two)
    by21, by24 = (
        -l1 * np.sin(three - q1) / (l2 * crossing),
        l4 * np.sin(three - q4) / (l2 * crossing),
    )
    by31, by34 = -l1 * np.sin(two - q1) / (l3 * crossing), l4 * np.sin(two - q4) / (l3 * crossing)
    w2, w3 = by21 * w1 + by24 * w4, by31 * w1 + by34 * w4
    drift2 = (
        l1 * np.cos(three - q1) * w1**2
        + l2 * np.cos(three - two) * w2**2
        - l4 * np.cos(three - q4) * w4**2
        - l3 * w3**2
    ) / (l2 * crossing)
    drift3 = (
        l1 * np.cos(two - q1) * w1**2
        + l2 * w2**2
        - l4 * np.cos(two - q4) * w4**2
        - l3 * np.cos(two - three) * w3**2
    ) / (l3 * crossing)
    return two, three, by21, by24, by31, by34, drift2, drift3


def arm(length: Any, angle: Any, rate: Any, by1: Any, by4: Any, drift: Any) -> Any:
    """What an arm on a turning link adds to a point: rates x, y per crank rate, and drift x, y.

    ``by1`` and ``by4`` are the link's rates per crank rate, ``drift`` its acceleration at constant ones.
    Order: x by crank 1, x by crank 4, y by crank 1, y by crank 4 [m], drift x, drift y [m/s^2].
    """
    x, y = length * np.cos(angle), length * np.sin(angle)
    return (
        -y * by1,
        -y * by4,
        x * by1,
        x * by4,
        -y * drift - x * rate**2,
        x * drift - y * rate**2,
    )
