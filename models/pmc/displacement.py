r"""Displacement analyses and Jacobian of the PepperMill-Carrier as scalar laws.

1. inverse   :math:`d_1 = x,\ d_2 = y` (2.8); :math:`\theta_i` from ``limb`` at the wrist heights
   :math:`v_1 = z + b_0 + p\phi,\ v_2 = z - b_0 - p\phi` (2.13c)
2. forward   :math:`z = (v_1 + v_2)/2,\ \phi = (v_1 - v_2 - 2 b_0)/(2p)` (2.14)-(2.15)
3. Jacobian  :math:`\dot v_1 = g_1\dot\theta_1 - \cot\beta_1\,\dot d_2`,
   :math:`\dot v_2 = -g_2\dot\theta_2 - \cot\beta_2\,\dot d_1`
4. motion    rates and accelerations of the joints from those of the pose, with the drifts of ``limb``

The printed (2.10b) has the sign of :math:`b_0` the other way round and contradicts (2.13c) and (2.15), which
agree with each other; with it 94 % of the postures of the working branch have no solution.

Poses are (x, y, z, phi), joints (d1, d2, theta1, theta2); ``elbow1`` ... ``forearm2`` are +1 or -1 as in
``limb``. r, l, b0 and p are the fields of ``Dimensions``.
"""

from typing import Any, NamedTuple

import numpy as np

from . import limb
from .limb import Scalar


class Dimensions(NamedTuple):
    """The four lengths that the laws depend on."""

    proximal: Scalar  # r [m]
    distal: Scalar  # l [m]
    spacing: Scalar  # b0 [m]
    pitch: Scalar  # p [m/rad]


def wrist_heights(z: Scalar, phi: Scalar, dim: Dimensions) -> Any:
    """Heights (v1, v2) of the wrists over their drive axes [m], eq. (2.13c)."""
    offset = dim.spacing + dim.pitch * phi
    return z + offset, z - offset


def joints(pose: Any, elbow1: float, elbow2: float, dim: Dimensions) -> Any:
    """Inverse displacement analysis (1) of one pose; angles wrapped, NaN out of reach."""
    x, y, z, phi = pose
    v1, v2 = wrist_heights(z, phi, dim)
    theta1 = limb.proximal_elevation(y, v1, elbow1, dim.proximal, dim.distal)
    theta2 = limb.wrap(
        0.5 * np.pi - limb.proximal_elevation(x, v2, elbow2, dim.proximal, dim.distal)
    )
    return x, y, theta1, theta2


def pose(joints: Any, forearm1: float, forearm2: float, dim: Dimensions) -> Any:
    """Forward displacement analysis (2) of one joint vector; NaN out of reach."""
    d1, d2, theta1, theta2 = joints
    v1 = limb.wrist_height(d2, theta1, forearm1, dim.proximal, dim.distal)
    v2 = limb.wrist_height(d1, 0.5 * np.pi - theta2, forearm2, dim.proximal, dim.distal)
    return d1, d2, 0.5 * (v1 + v2), (0.5 * (v1 - v2) - dim.spacing) / dim.pitch


def elevations(pose: Any, joints: Any, dim: Dimensions) -> Any:
    """Elevations (alpha1, beta1, alpha2, beta2) of the links [rad] of a closed posture."""
    x, y, z, phi = pose
    v1, v2 = wrist_heights(z, phi, dim)
    alpha1, alpha2 = joints[2], 0.5 * np.pi - joints[3]
    beta1 = limb.distal_elevation(y, v1, alpha1, dim.proximal)
    beta2 = limb.distal_elevation(x, v2, alpha2, dim.proximal)
    return alpha1, beta1, alpha2, beta2


def wrist_gradients(pose: Any, joints: Any, dim: Dimensions) -> Any:
    """Partial derivatives (dv1/dd2, dv1/dtheta1, dv2/dd1, dv2/dtheta2), law (3)."""
    alpha1, beta1, alpha2, beta2 = elevations(pose, joints, dim)
    return (
        limb.height_per_reach(beta1),
        limb.height_per_elevation(alpha1, beta1, dim.proximal),
        limb.height_per_reach(beta2),
        -limb.height_per_elevation(alpha2, beta2, dim.proximal),
    )


def joint_motion(pose: Any, pose_rate: Any, pose_acceleration: Any, dim: Dimensions) -> Any:
    """Joints, joint rates and accelerations (three tuples of 4) of a motion in the working mode, law (4)."""
    w = joints(pose, 1.0, 1.0, dim)
    vx, vy, vz, vphi = pose_rate
    w1, w2 = vz + dim.pitch * vphi, vz - dim.pitch * vphi
    # Rates first: the drifts depend on them.
    k1, g1, k2, g2 = wrist_gradients(pose, w, dim)
    rate1, rate2 = (w1 - k1 * vy) / g1, (w2 - k2 * vx) / g2
    rates = (vx, vy, rate1, rate2)
    return w, rates, joint_acceleration(w, rates, pose_acceleration, dim)


def joint_acceleration(w: Any, w_rate: Any, pose_acceleration: Any, dim: Dimensions) -> Any:
    """Joint accelerations (4) that accelerate the pose as asked, at joints and rates of the working branch."""
    ax, ay, az, aphi = pose_acceleration
    one = limb.motion(w[1], w[2], w_rate[1], w_rate[2], dim.proximal, dim.distal)
    alpha2 = 0.5 * np.pi - w[3]
    two = limb.motion(w[0], alpha2, w_rate[0], -w_rate[3], dim.proximal, dim.distal)
    v1, v2 = az + dim.pitch * aphi, az - dim.pitch * aphi
    return (
        ax,
        ay,
        (v1 - one.height_by_h * ay - one.height_drift) / one.height_by_alpha,
        -(v2 - two.height_by_h * ax - two.height_drift) / two.height_by_alpha,
    )
