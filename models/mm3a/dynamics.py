r"""Equations of motion of the MM3A (Damani 2013, chapter 3 and appendix A.3).

1. :math:`M(q)\ddot q + C(q, \dot q)\dot q + G(q) - J^T f = \tau`              (3.2, A.114)
2. :math:`M_{jj}\ddot q_j + G_j - (J^T f)_j = \tau_j`, one joint moving         (3.3)

:math:`f` is a force on the tip, gravity a vector in frame 0 (``arm.gravity_in_base``). The links are
symmetric, so :math:`M` is diagonal: (A.65) vanishes identically. Corrections to the printed equations,
found by comparison with a MultibodyPlant:

- (A.95), (A.108) :math:`c_{322} = -\tfrac12 \partial M_{22}/\partial q_3 = -m_3 (l_2 + q_3 - r_3)`;
  printed without the sign, which breaks the skew symmetry of :math:`\dot M - 2C`.
- (A.17) the lever of joint j starts at :math:`O_{j-1}`, not at :math:`O_i`.
- (A.54) `R` is :math:`r_3`.

Rows and columns are joints 1-3; units kg m^2, N m for joints 1 and 2, kg, N for joint 3. Not
modelled: joint friction and the actuators (``stick_slip.py``), flexible links.
"""

from typing import Any

import numpy as np

from . import kinematics

Vector = tuple[Any, Any, Any]


def mass_diagonal(q: Any, arm: Any) -> Vector:
    """Diagonal of M (A.64, A.68, A.72); all other elements are zero."""
    s2, c2 = np.sin(q[1]), np.cos(q[1])
    out = arm.forearm + q[2] - arm.centre_3
    lever_2 = arm.shoulder - arm.centre_2 * s2
    lever_3 = arm.shoulder - out * s2
    about_1 = (
        arm.mass_1 * arm.centre_1**2
        + arm.mass_2 * lever_2**2
        + arm.mass_3 * lever_3**2
        + arm.inertia_1y
        + (arm.inertia_2x + arm.inertia_3x) * s2**2
        + (arm.inertia_2z + arm.inertia_3z) * c2**2
    )
    about_2 = arm.mass_2 * arm.centre_2**2 + arm.mass_3 * out**2 + arm.inertia_2y + arm.inertia_3y
    return about_1, about_2, arm.mass_3 + 0.0 * out


def coriolis_matrix(q: Any, rate: Any, arm: Any) -> tuple[Vector, Vector, Vector]:
    """Rows of C (A.100) from Christoffel symbols, with the sign of C_32 corrected."""
    s2, c2 = np.sin(q[1]), np.cos(q[1])
    out = arm.forearm + q[2] - arm.centre_3
    lever_2 = arm.shoulder - arm.centre_2 * s2
    lever_3 = arm.shoulder - out * s2
    by_2 = (
        s2 * c2 * (arm.inertia_2x + arm.inertia_3x - arm.inertia_2z - arm.inertia_3z)
        - arm.mass_2 * arm.centre_2 * c2 * lever_2
        - arm.mass_3 * out * c2 * lever_3
    )
    by_3 = -arm.mass_3 * s2 * lever_3
    pull = arm.mass_3 * out
    v1, v2, v3 = rate
    return (
        (by_2 * v2 + by_3 * v3, by_2 * v1, by_3 * v1),
        (-by_2 * v1, pull * v3, pull * v2),
        (-by_3 * v1, -pull * v2, 0.0 * v1),
    )


def moment_1(q: Any, arm: Any) -> Any:
    """First moment of the moving mass about the axis of joint 1, along x_1 [kg m]."""
    s2 = np.sin(q[1])
    out = arm.forearm + q[2] - arm.centre_3
    return (
        arm.mass_1 * arm.centre_1
        + arm.mass_2 * (arm.shoulder - arm.centre_2 * s2)
        + arm.mass_3 * (arm.shoulder - out * s2)
    )


def moment_2(q: Any, arm: Any) -> Any:
    """First moment of links 2 and 3 about the axis of joint 2, along z_2 [kg m]."""
    return arm.mass_2 * arm.centre_2 + arm.mass_3 * (arm.forearm + q[2] - arm.centre_3)


def gravity_load(q: Any, gravity: Any, arm: Any) -> Vector:
    """G (3.7-3.9, A.111-A.113): what the actuators hold against ``gravity`` in frame 0."""
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    g1, g2, g3 = gravity
    return (
        moment_1(q, arm) * (g1 * s1 - g2 * c1),
        moment_2(q, arm) * (g1 * c1 * c2 + g2 * s1 * c2 + g3 * s2),
        arm.mass_3 * (g1 * c1 * s2 + g2 * s1 * s2 - g3 * c2),
    )


def static_load(q: Any, gravity: Any, force: Any, arm: Any) -> Vector:
    """Load the actuators hold at rest, G - J^T f: positive opposes motion in positive direction.

    ``force`` [N] acts on the tip, in frame 0. A joint cannot tell it from gravity (chapter 3).
    """
    rows = kinematics.jacobian(q, arm)
    load = gravity_load(q, gravity, arm)
    fx, fy, fz = force
    return (
        load[0] - rows[0][0] * fx - rows[1][0] * fy - rows[2][0] * fz,
        load[1] - rows[0][1] * fx - rows[1][1] * fy - rows[2][1] * fz,
        load[2] - rows[0][2] * fx - rows[1][2] * fy - rows[2][2] * fz,
    )


def effort(q: Any, rate: Any, acceleration: Any, gravity: Any, force: Any, arm: Any) -> Vector:
    """Joint torques and force (1) that produce ``acceleration``."""
    inertia = mass_diagonal(q, arm)
    rows = coriolis_matrix(q, rate, arm)
    load = static_load(q, gravity, force, arm)
    v1, v2, v3 = rate
    return (
        inertia[0] * acceleration[0]
        + (rows[0][0] * v1 + rows[0][1] * v2 + rows[0][2] * v3)
        + load[0],
        inertia[1] * acceleration[1]
        + (rows[1][0] * v1 + rows[1][1] * v2 + rows[1][2] * v3)
        + load[1],
        inertia[2] * acceleration[2]
        + (rows[2][0] * v1 + rows[2][1] * v2 + rows[2][2] * v3)
        + load[2],
    )


def single_joint_effort(
    joint: int, acceleration: Any, q: Any, gravity: Any, force: Any, arm: Any
) -> Any:
    """Torque or force (2) of ``joint`` (0, 1, 2) while the other two stand still.

    The Coriolis terms vanish at every speed of that joint: C q' has no term in the square of a joint's
    own rate.
    """
    load = static_load(q, gravity, force, arm)
    return mass_diagonal(q, arm)[joint] * acceleration + load[joint]
