r"""Equations of motion of the PepperMill-Carrier in its four joint coordinates, in closed form.

.. math:: M(w)\,\ddot w + c(w, \dot w) = f, \qquad w = (d_1, d_2, \theta_1, \theta_2)

by energy equivalence, from the bodies' velocities as functions of :math:`\dot w`:

1. a limb is a planar two-link arm in its elevations :math:`(\alpha, \beta)` whose tip carries the wrist,
   moved as a whole along the drive axis:
   :math:`M_{11} = I_A + (m_d + m_w) r^2,\ M_{22} = I_d + m_d c^2 + m_w l^2,\
   M_{12} = (m_d c + m_w l)\, r \cos(\alpha - \beta)`;
2. its reach is the other carriage, :math:`h = r\cos\alpha + l\cos\beta`, hence
   :math:`\dot\beta = B_h \dot h + B_\alpha \dot\alpha`, and (1) is projected on :math:`(\dot\alpha, \dot h)`;
3. the PM translates with :math:`(x, y, z)` and turns with :math:`\dot\phi`, by the Jacobian of
   ``displacement``;
4. the counterweight hangs on a rope of length L from the PM over a pulley: mass
   :math:`m_c + I_p / \rho^2` in :math:`\dot L`, weight, and dry friction of the pulley;
5. viscous friction in elbows, wrists and nuts, and the friction of the two C-drives (2.6) in their motors' and
   collars' speeds.

:math:`f` are carriage forces [N] and drive torques [N m]. Not modelled: clearance and compliance
(``prototype``), a slack rope (watch :func:`rope_tension`). Every law takes floats, AutoDiffXd or Expressions.
"""

from typing import Any, NamedTuple

import numpy as np

from .. import friction
from . import displacement, limb
from .displacement import Dimensions
from .limb import Scalar


class Constants(NamedTuple):
    """Constants of (1)-(5) in SI units, see ``constants.of``."""

    dimensions: Dimensions
    gravity: Scalar  # [m/s^2]
    axial_mass: Scalar  # that a carriage moves along its axis, with rotors [kg]
    crank_inertia: Scalar  # I_A about the drive axis, with rotors [kg m^2]
    crank_moment: Scalar  # mass times centre distance of the proximal link [kg m]
    rod_mass: Scalar  # m_d [kg]
    rod_centre: Scalar  # c [m]
    rod_inertia: Scalar  # I_d about its centre [kg m^2]
    wrist_mass: Scalar  # m_w [kg]
    mill_mass: Scalar  # PM with payload [kg]
    mill_inertia: Scalar  # about its axis [kg m^2]
    elbow_damping: Scalar  # [N m s/rad]
    wrist_damping: Scalar  # [N m s/rad]
    screw_damping: Scalar  # of both nuts [N m s/rad]
    rope_mass: Scalar  # m_c + I_p / rho^2 [kg]
    rope_weight: Scalar  # m_c g [N]
    rope_friction: Scalar  # [N]
    rope_friction_speed: Scalar  # [m/s]
    pulley_x: Scalar  # [m]
    pulley_y: Scalar  # [m]
    pulley_z: Scalar  # less the height of the rope's end over C [m]
    per_metre: Scalar  # 2 pi / p_c of the C-drives [rad/m]
    motor_viscous: Scalar  # beta [N m s/rad]
    collar_viscous: Scalar  # gamma / 2 [N m s/rad]
    motor_dry: Scalar  # delta [N m]
    collar_dry: Scalar  # eta [N m]
    dry_speed: Scalar  # width of the smoothed sign [rad/s]


class LimbTerms(NamedTuple):
    """One limb in its elevation alpha and reach h."""

    inertia: Any  # (aa, ah, hh) [kg m^2, kg m, kg]
    bias: Any  # forces on (alpha, h) at zero acceleration [N m, N]
    gradient: Any  # (dv/dalpha, dv/dh) [m/rad, -]
    drift: Any  # second derivative of v at zero acceleration [m/s^2]
    height: Any  # v [m]


def limb_terms(
    alpha: Scalar, h: Scalar, alpha_rate: Scalar, h_rate: Scalar, c: Constants
) -> LimbTerms:
    """Laws (1) and (2) of one limb, elbow up and forearm down."""
    r, rod = c.dimensions.proximal, c.dimensions.distal
    m = limb.motion(h, alpha, h_rate, alpha_rate, r, rod)
    by_h, by_alpha = m.beta_by_h, m.beta_by_alpha
    coupling = (c.rod_mass * c.rod_centre + c.wrist_mass * rod) * r
    m11 = c.crank_inertia + (c.rod_mass + c.wrist_mass) * r * r
    m12 = coupling * (m.cos_alpha * m.cos_beta + m.sin_alpha * m.sin_beta)
    m22 = c.rod_inertia + c.rod_mass * c.rod_centre * c.rod_centre + c.wrist_mass * rod * rod
    whirl = coupling * (m.sin_alpha * m.cos_beta - m.cos_alpha * m.sin_beta)
    crank_weight = c.gravity * (c.crank_moment + (c.rod_mass + c.wrist_mass) * r)
    rod_weight = c.gravity * coupling / r
    elbow = c.elbow_damping * (m.beta_rate - alpha_rate)
    on_alpha = (
        m12 * m.beta_drift + whirl * m.beta_rate * m.beta_rate + crank_weight * m.cos_alpha - elbow
    )
    on_beta = (
        m22 * m.beta_drift
        - whirl * alpha_rate * alpha_rate
        + rod_weight * m.cos_beta
        + elbow
        + c.wrist_damping * m.beta_rate
    )
    return LimbTerms(
        (
            m11 + 2.0 * by_alpha * m12 + by_alpha * by_alpha * m22,
            by_h * (m12 + by_alpha * m22),
            by_h * by_h * m22,
        ),
        (on_alpha + by_alpha * on_beta, by_h * on_beta),
        (m.height_by_alpha, m.height_by_h),
        m.height_drift,
        m.height,
    )


def mill_terms(one: LimbTerms, two: LimbTerms, c: Constants) -> Any:
    """Law (3): rows of the Jacobian for z and phi, each with its drift at zero joint acceleration."""
    (g1, k1), (g2, k2) = one.gradient, two.gradient
    by_p = 0.5 / c.dimensions.pitch
    return (
        (0.5 * k2, 0.5 * k1, 0.5 * g1, -0.5 * g2, 0.5 * (one.drift + two.drift)),
        (-by_p * k2, by_p * k1, by_p * g1, by_p * g2, by_p * (one.drift - two.drift)),
    )


def rope_terms(position: Any, velocity: Any, c: Constants) -> Any:
    """Law (4): direction of the rope away from the pulley, its pull at rest, and L'' at zero acceleration."""
    ax, ay = position[0] - c.pulley_x, position[1] - c.pulley_y
    az = position[2] - c.pulley_z
    length = np.sqrt(ax * ax + ay * ay + az * az)
    ux, uy, uz = ax / length, ay / length, az / length
    rate = ux * velocity[0] + uy * velocity[1] + uz * velocity[2]
    squared = velocity[0] * velocity[0] + velocity[1] * velocity[1] + velocity[2] * velocity[2]
    drag = c.rope_friction * friction.smooth_sign(rate, c.rope_friction_speed)
    return (ux, uy, uz), c.rope_weight + drag, (squared - rate * rate) / length


def equations(w: Any, w_rate: Any, c: Constants) -> Any:
    """M as its ten entries (11 12 13 14 22 23 24 33 34 44) and the bias c as four, in joint order."""
    d1, d2, theta1, theta2 = w
    s1, s2, theta1_rate, theta2_rate = w_rate
    # Limb 2 counts its angle from the vertical: its signs of alpha turn round.
    one = limb_terms(theta1, d2, theta1_rate, s2, c)
    two = limb_terms(0.5 * np.pi - theta2, d1, -theta2_rate, s1, c)
    aa1, ah1, hh1 = one.inertia
    aa2, ah2, hh2 = two.inertia
    (z1, z2, z3, z4, z_drift), (f1, f2, f3, f4, phi_drift) = mill_terms(one, two, c)
    z_rate = z1 * s1 + z2 * s2 + z3 * theta1_rate + z4 * theta2_rate
    phi_rate = f1 * s1 + f2 * s2 + f3 * theta1_rate + f4 * theta2_rate
    z = 0.5 * (one.height + two.height)
    (ux, uy, uz), pull, rope_drift = rope_terms((d1, d2, z), (s1, s2, z_rate), c)

    rope, mass, spin = c.rope_mass, c.mill_mass, c.mill_inertia
    # Force of PM and rope at zero joint acceleration on x, y, z, and torque on phi.
    tension = pull + rope * (rope_drift + uz * z_drift)
    on_z = mass * (z_drift + c.gravity) + tension * uz
    on_phi = spin * phi_drift + c.screw_damping * phi_rate
    # Rope direction per joint rate.
    r1, r2, r3, r4 = ux + uz * z1, uy + uz * z2, uz * z3, uz * z4
    sliding = c.axial_mass + mass
    friction1 = drive_friction(s1, theta1_rate, c)
    friction2 = drive_friction(s2, theta2_rate, c)
    matrix = (
        sliding + hh2 + mass * z1 * z1 + spin * f1 * f1 + rope * r1 * r1,
        mass * z1 * z2 + spin * f1 * f2 + rope * r1 * r2,
        mass * z1 * z3 + spin * f1 * f3 + rope * r1 * r3,
        -ah2 + mass * z1 * z4 + spin * f1 * f4 + rope * r1 * r4,
        sliding + hh1 + mass * z2 * z2 + spin * f2 * f2 + rope * r2 * r2,
        ah1 + mass * z2 * z3 + spin * f2 * f3 + rope * r2 * r3,
        mass * z2 * z4 + spin * f2 * f4 + rope * r2 * r4,
        aa1 + mass * z3 * z3 + spin * f3 * f3 + rope * r3 * r3,
        mass * z3 * z4 + spin * f3 * f4 + rope * r3 * r4,
        aa2 + mass * z4 * z4 + spin * f4 * f4 + rope * r4 * r4,
    )
    bias = (
        two.bias[1] + on_z * z1 + on_phi * f1 + tension * ux + friction1[0],
        one.bias[1] + on_z * z2 + on_phi * f2 + tension * uy + friction2[0],
        one.bias[0] + on_z * z3 + on_phi * f3 + friction1[1],
        -two.bias[0] + on_z * z4 + on_phi * f4 + friction2[1],
    )
    return matrix, bias


def drive_friction(carriage_rate: Scalar, angle_rate: Scalar, c: Constants) -> Any:
    """Law (5) of one C-drive: force on the carriage [N] and torque on the drive angle [N m].

    Elements as in eq. (2.6): both motors, and the collar at the difference of their speeds.
    """
    slide = c.per_metre * carriage_rate
    left = _element(angle_rate + slide, c.motor_viscous, c.motor_dry, c.dry_speed)
    right = _element(angle_rate - slide, c.motor_viscous, c.motor_dry, c.dry_speed)
    collar = _element(2.0 * slide, c.collar_viscous, c.collar_dry, c.dry_speed)
    return c.per_metre * (left - right + 2.0 * collar), left + right


def _element(speed: Scalar, coefficient: Scalar, level: Scalar, width: Scalar) -> Scalar:
    return friction.viscous(speed, coefficient, 0.0) + level * friction.smooth_sign(speed, width)


def acceleration(w: Any, w_rate: Any, force: Any, c: Constants) -> Any:
    """Joint accelerations under joint forces ``force`` (4,)."""
    matrix, bias = equations(w, w_rate, c)
    return solve_symmetric(
        matrix, (force[0] - bias[0], force[1] - bias[1], force[2] - bias[2], force[3] - bias[3])
    )


def inverse_dynamics(w: Any, w_rate: Any, w_acceleration: Any, c: Constants) -> Any:
    """Joint forces that produce the accelerations."""
    m, bias = equations(w, w_rate, c)
    a, b, e, f = w_acceleration
    return (
        m[0] * a + m[1] * b + m[2] * e + m[3] * f + bias[0],
        m[1] * a + m[4] * b + m[5] * e + m[6] * f + bias[1],
        m[2] * a + m[5] * b + m[7] * e + m[8] * f + bias[2],
        m[3] * a + m[6] * b + m[8] * e + m[9] * f + bias[3],
    )


def kinetic_energy(w: Any, w_rate: Any, c: Constants) -> Scalar:
    """Kinetic energy with rotors and counterweight [J]."""
    m, _ = equations(w, w_rate, c)
    a, b, e, f = w_rate
    diagonal = m[0] * a * a + m[4] * b * b + m[7] * e * e + m[9] * f * f
    mixed = a * (m[1] * b + m[2] * e + m[3] * f) + b * (m[5] * e + m[6] * f) + m[8] * e * f
    return 0.5 * diagonal + mixed


def potential_energy(w: Any, c: Constants) -> Scalar:
    """Potential energy of limbs, PM and counterweight [J], zero at the drive axes and the pulley."""
    r = c.dimensions.proximal
    x, y, z, phi = displacement.pose(w, -1.0, -1.0, c.dimensions)
    v1, v2 = displacement.wrist_heights(z, phi, c.dimensions)
    share = c.rod_centre / c.dimensions.distal
    total = c.gravity * c.mill_mass * z
    for alpha, v in ((w[2], v1), (0.5 * np.pi - w[3], v2)):
        elbow = r * np.sin(alpha)
        total = total + c.gravity * (
            c.crank_moment * np.sin(alpha)
            + c.rod_mass * (elbow + share * (v - elbow))
            + c.wrist_mass * v
        )
    ax, ay, az = x - c.pulley_x, y - c.pulley_y, z - c.pulley_z
    return total + c.rope_weight * np.sqrt(ax * ax + ay * ay + az * az)


def rope_tension(w: Any, w_rate: Any, w_acceleration: Any, c: Constants) -> Scalar:
    """Tension of the rope at the PM [N]; the model holds while it is positive."""
    one = limb_terms(w[2], w[1], w_rate[2], w_rate[1], c)
    two = limb_terms(0.5 * np.pi - w[3], w[0], -w_rate[3], w_rate[0], c)
    z1, z2, z3, z4, z_drift = mill_terms(one, two, c)[0]
    a, b, e, f = w_acceleration
    z_rate = z1 * w_rate[0] + z2 * w_rate[1] + z3 * w_rate[2] + z4 * w_rate[3]
    z_second = z1 * a + z2 * b + z3 * e + z4 * f + z_drift
    z = 0.5 * (one.height + two.height)
    (ux, uy, uz), pull, drift = rope_terms((w[0], w[1], z), (w_rate[0], w_rate[1], z_rate), c)
    second = drift + ux * a + uy * b + uz * z_second
    return pull + c.rope_mass * second


def wrist_loads(w: Any, w_rate: Any, w_acceleration: Any, c: Constants) -> Any:
    """Vertical forces (1, 2) that the limbs exert on wrists and PM [N]."""
    one = limb_terms(w[2], w[1], w_rate[2], w_rate[1], c)
    two = limb_terms(0.5 * np.pi - w[3], w[0], -w_rate[3], w_rate[0], c)
    a, b, e, f = w_acceleration
    z1, z2, z3, z4, z_drift = mill_terms(one, two, c)[0]
    f1, f2, f3, f4, phi_drift = mill_terms(one, two, c)[1]
    z_second = z1 * a + z2 * b + z3 * e + z4 * f + z_drift
    phi_second = f1 * a + f2 * b + f3 * e + f4 * f + phi_drift
    phi_rate = f1 * w_rate[0] + f2 * w_rate[1] + f3 * w_rate[2] + f4 * w_rate[3]
    z_rate = z1 * w_rate[0] + z2 * w_rate[1] + z3 * w_rate[2] + z4 * w_rate[3]
    position = (w[0], w[1], 0.5 * (one.height + two.height))
    (_, _, uz), _, _ = rope_terms(position, (w_rate[0], w_rate[1], z_rate), c)
    pull = rope_tension(w, w_rate, w_acceleration, c) * uz
    half = 0.5 * (c.mill_mass * (z_second + c.gravity) + pull)
    turning = 0.5 * (c.mill_inertia * phi_second + c.screw_damping * phi_rate) / c.dimensions.pitch
    difference = c.dimensions.pitch * phi_second
    return (
        half + turning + c.wrist_mass * (z_second + difference + c.gravity),
        half - turning + c.wrist_mass * (z_second - difference + c.gravity),
    )


def solve_symmetric(m: Any, b: Any) -> Any:
    """Solution of a symmetric positive definite 4 x 4 system, M as in :func:`equations` (L D L^T)."""
    d1 = m[0]
    l21, l31, l41 = m[1] / d1, m[2] / d1, m[3] / d1
    d2 = m[4] - l21 * m[1]
    u32, u42 = m[5] - l31 * m[1], m[6] - l41 * m[1]
    l32, l42 = u32 / d2, u42 / d2
    d3 = m[7] - l31 * m[2] - l32 * u32
    u43 = m[8] - l41 * m[2] - l42 * u32
    l43 = u43 / d3
    d4 = m[9] - l41 * m[3] - l42 * u42 - l43 * u43
    y1 = b[0]
    y2 = b[1] - l21 * y1
    y3 = b[2] - l31 * y1 - l32 * y2
    y4 = b[3] - l41 * y1 - l42 * y2 - l43 * y3
    x4 = y4 / d4
    x3 = y3 / d3 - l43 * x4
    x2 = y2 / d2 - l32 * x3 - l42 * x4
    return y1 / d1 - l21 * x2 - l31 * x3 - l41 * x4, x2, x3, x4
