r"""One limb of the PepperMill-Carrier: a planar crank r and connecting rod l in a vertical plane.

1. closure                :math:`h = r\cos\alpha + l\cos\beta,\quad v = r\sin\alpha + l\sin\beta`
2. inverse                :math:`\alpha = \mathrm{atan2}(v, h) + e\,\mathrm{atan2}(\sqrt\Delta,
   \rho^2 + r^2 - l^2)`, :math:`\rho^2 = h^2 + v^2`,
   :math:`\Delta = ((r+l)^2 - \rho^2)(\rho^2 - (r-l)^2)`, elbow :math:`e = \pm 1`
3. forward                :math:`v = r\sin\alpha + f\sqrt{l^2 - (h - r\cos\alpha)^2}`,
   forearm :math:`f = \pm 1`
4. velocity               :math:`\dot v = -\cot\beta\,\dot h + g\,\dot\alpha`,
   :math:`g = r\sin(\beta - \alpha)/\sin\beta`
5. acceleration           :math:`\ddot\beta = B_h\ddot h + B_\alpha\ddot\alpha + b`,
   :math:`B_h = -1/(l\sin\beta)`, :math:`B_\alpha = r\sin\alpha\,B_h`,
   :math:`b = B_h(r\cos\alpha\,\dot\alpha^2 + l\cos\beta\,\dot\beta^2)`

Inputs are the reach h and height v of the wrist over the drive axis [m] and elevations above the
horizontal [rad]. ``elbow`` is +1 with the elbow above the line from drive to wrist, -1 below; ``forearm`` is
+1 with the wrist above the elbow, -1 below. The prototype works elbow up and forearm down.

(2) solves eq. (2.9) of Friedlaender 2015 without the tan-half substitution, whose closed form (2.12e, 2.13)
cancels where :math:`C_i = A_i` - at the isotropic posture among others - and must be wrapped. The printed
(2.11) has a cosine for the sine of the second identity. (3) is one limb of (2.14)-(2.17).
"""

from typing import Any, NamedTuple

import numpy as np

# A scalar that is a float, an AutoDiffXd or an Expression.
Scalar = Any


class Motion(NamedTuple):
    """Sines, cosines, velocities and drifts of one limb, laws (4) and (5)."""

    sin_alpha: Any
    cos_alpha: Any
    sin_beta: Any
    cos_beta: Any
    beta_rate: Any  # [rad/s]
    beta_by_h: Any  # B_h [rad/m]
    beta_by_alpha: Any  # B_alpha [-]
    beta_drift: Any  # b, second derivative of beta at constant rates [rad/s^2]
    height: Any  # v [m]
    height_by_h: Any  # -cot(beta) [-]
    height_by_alpha: Any  # g [m/rad]
    height_drift: Any  # second derivative of v at constant rates [m/s^2]


def proximal_elevation(
    h: Scalar, v: Scalar, elbow: float, proximal: Scalar, distal: Scalar
) -> Scalar:
    """Elevation of the proximal link in (-pi, pi], law (2); NaN for floats out of reach."""
    squared = h * h + v * v
    longest, shortest = proximal + distal, proximal - distal
    discriminant = (longest * longest - squared) * (squared - shortest * shortest)
    inner = np.arctan2(np.sqrt(discriminant), squared + longest * shortest)
    return wrap(np.arctan2(v, h) + elbow * inner)


def wrist_height(
    h: Scalar, alpha: Scalar, forearm: float, proximal: Scalar, distal: Scalar
) -> Scalar:
    """Height of the wrist over the drive axis, law (3); NaN for floats out of reach."""
    across = h - proximal * np.cos(alpha)
    return proximal * np.sin(alpha) + forearm * np.sqrt((distal - across) * (distal + across))


def distal_elevation(h: Scalar, v: Scalar, alpha: Scalar, proximal: Scalar) -> Scalar:
    """Elevation of the distal link in (-pi, pi], from the closure (1)."""
    return np.arctan2(v - proximal * np.sin(alpha), h - proximal * np.cos(alpha))


def height_per_reach(beta: Scalar) -> Scalar:
    """Partial derivative of v by h at constant alpha, law (4) [-]."""
    return -np.cos(beta) / np.sin(beta)


def height_per_elevation(alpha: Scalar, beta: Scalar, proximal: Scalar) -> Scalar:
    """Partial derivative g of v by alpha at constant h, law (4) [m/rad].

    Zero where the links are parallel (serial singularity), infinite where the distal link is
    horizontal (parallel singularity). A wrist force F along z loads the drive with the torque g F.
    """
    return proximal * np.sin(beta - alpha) / np.sin(beta)


def motion(
    h: Scalar, alpha: Scalar, h_rate: Scalar, alpha_rate: Scalar, proximal: Scalar, distal: Scalar
) -> Motion:
    """Laws (4) and (5) of a limb with its forearm down, from reach, elevation and their rates."""
    sin_a, cos_a = np.sin(alpha), np.cos(alpha)
    # The closure (1) gives sine and cosine of beta without the angle itself.
    cos_b = (h - proximal * cos_a) / distal
    sin_b = -np.sqrt((1.0 - cos_b) * (1.0 + cos_b))
    by_h = -1.0 / (distal * sin_b)
    by_alpha = by_h * proximal * sin_a
    rate = by_h * h_rate + by_alpha * alpha_rate
    alpha_bend = proximal * alpha_rate * alpha_rate
    beta_bend = distal * rate * rate
    drift = by_h * (cos_a * alpha_bend + cos_b * beta_bend)
    return Motion(
        sin_a,
        cos_a,
        sin_b,
        cos_b,
        rate,
        by_h,
        by_alpha,
        drift,
        proximal * sin_a + distal * sin_b,
        -cos_b / sin_b,
        proximal * (cos_a - sin_a * cos_b / sin_b),
        distal * cos_b * drift - sin_a * alpha_bend - sin_b * beta_bend,
    )


def wrap(angle: Scalar) -> Scalar:
    """The same angle in (-pi, pi], eq. (2.28c)."""
    return angle + 2.0 * np.pi * np.floor((np.pi - angle) / (2.0 * np.pi))
