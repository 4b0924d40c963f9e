r"""Friction laws of one sliding or turning contact.

Each function returns the force or torque that opposes the motion, positive for positive speed; the
equation of motion subtracts it. Speeds in rad/s with torques in N m, or m/s with forces in N.

1. viscous                :math:`f = b v`
2. Coulomb, smoothed      :math:`f = F_c \tanh(v / w)`
3. Coulomb by direction   :math:`f = F^+` for v >> w, :math:`-F^-` for v << -w
4. Stribeck               :math:`f = (F_c + (F_s - F_c) e^{-(v/v_s)^2}) \tanh(v / w)`
5. LuGre / Dahl           :math:`\dot z = v - \sigma_0 |v| z / g(v)`,
                          :math:`f = \sigma_0 z + \sigma_1 \dot z`
6. sech form              :math:`f = b v + (F_c + F_x \operatorname{sech}(\alpha v)) \tanh(\beta v)` (2.26, 2.27)
7. Stribeck level         :math:`g = F_c + (F_s - F_c) e^{-|v/v_s|^\delta}` (2.25, without its viscous term)
8. stiction, Karnopp      :math:`f = g\,\mathrm{sgn}\,v` for :math:`|v| > w`, else the applied force up to
                          :math:`F_s` (2.24); w = 0 is (2.24) as printed

The raw sign of (2)-(4) chatters in fixed-step integration, hence the width ``w``. Not modelled
here: dependence on temperature or wear. Sources: Friedlaender 2015, eqs. (2.6b-c); Canudas de Wit et al.
1995 for (5); Roldan, section 2.4.2 for (6)-(8). Roldan says that Karnopp's force is zero inside the zero
velocity interval: then nothing would ever stick. Karnopp 1985 has it balance the applied force, as here.
Maxwell slip stands in ``presliding``.
"""

from typing import Any

import numpy as np

from . import elementary

# A scalar that is a float, an AutoDiffXd or an Expression: every law here takes any of them.
Scalar = Any


def smooth_sign(v: Scalar, width: Scalar) -> Scalar:
    """Odd step from -1 to 1 that replaces sgn(v); 76 % of the step at ``v = width``."""
    return elementary.tanh(v / width)


def viscous(v: Scalar, coefficient: Scalar, skew: Scalar = 0.0) -> Scalar:
    """Friction proportional to speed (eq. 2.6b of Friedlaender for one element).

    ``skew`` is what the coefficient has more at positive and less at negative speed.
    """
    if skew == 0.0:
        return coefficient * v
    return coefficient * v + skew * np.abs(v)


def dry(
    v: Scalar,
    forward: Scalar,
    backward: Scalar,
    breakaway: Scalar,
    stribeck_speed: Scalar,
    width: Scalar,
    exponent: float = 2.0,
) -> Scalar:
    """Dry friction with its own level in each direction and an optional Stribeck peak.

    ``forward`` and ``backward`` are the levels at high speed, ``breakaway`` (>= 0) is what the level
    has on top of them at standstill, ``stribeck_speed`` how fast that decays, ``exponent`` in which shape. With
    equal levels and no breakaway this is the smoothed Coulomb law of eq. (2.6c).
    """
    peak = stribeck_peak(v, breakaway, stribeck_speed, exponent)
    return sliding(v, forward, backward, peak, width)


def sliding(v: Scalar, forward: Scalar, backward: Scalar, peak: Scalar, width: Scalar) -> Scalar:
    """Dry friction of two levels, both raised by ``peak``: ``dry`` where the peak is known."""
    step = smooth_sign(v, width)
    mean = 0.5 * (forward + backward) + peak
    if forward == backward:
        return mean * step
    return mean * step + 0.5 * (forward - backward) * step * step


def stribeck_peak(
    v: Scalar, breakaway: Scalar, stribeck_speed: Scalar, exponent: float = 2.0
) -> Scalar:
    """What the level at speed ``v`` has on top of that at high speed, (4).

    ``exponent`` (Bo and Pavelescu 1982) is 2 for the Gaussian decay, 1 for Tustin's.
    """
    ratio = v / stribeck_speed
    if exponent == 2.0:
        return breakaway * np.exp(-ratio * ratio)
    return breakaway * np.exp(-(np.abs(ratio) ** exponent))


def bristle_rate(v: Scalar, deflection: Scalar, stiffness: Scalar, level: Scalar) -> Scalar:
    """Rate of the bristle deflection z of the LuGre and Dahl models; ``level`` is g(v) > 0."""
    return v - stiffness * np.abs(v) * deflection / level


def bristle_force(deflection: Scalar, rate: Scalar, stiffness: Scalar, damping: Scalar) -> Scalar:
    """Force of the bristles; Dahl's model is ``damping = 0``."""
    return stiffness * deflection + damping * rate


def bristle_step(
    v: Scalar, deflection: Scalar, stiffness: Scalar, level: Scalar, dt: Scalar
) -> Scalar:
    """Deflection after ``dt`` at constant speed: exact, so stiff bristles stay stable at any step."""
    steady = level * np.sign(v) / stiffness
    return steady + (deflection - steady) * np.exp(-stiffness * np.abs(v) * dt / level)


def sech_dry(
    v: Scalar, viscous: Scalar, coulomb: Scalar, excess: Scalar, alpha: Scalar, beta: Scalar
) -> Scalar:
    """Law (6), (2.27) of Roldan; ``excess = 0`` is (4.10), and (2.26) without the viscous term.

    ``alpha`` and ``beta`` in 1/speed: how fast the excess decays and the sign changes.
    """
    return viscous * v + (coulomb + excess / np.cosh(alpha * v)) * elementary.tanh(beta * v)


def stribeck_level(
    v: Scalar, coulomb: Scalar, static: Scalar, stribeck_speed: Scalar, exponent: float = 2.0
) -> Scalar:
    """Level g(v) of dry friction (7), from ``static`` at rest to ``coulomb`` at speed."""
    return coulomb + stribeck_peak(v, static - coulomb, stribeck_speed, exponent)


def karnopp(v: float, applied: float, level: float, static: float, dead_speed: float) -> float:
    """Law (8) for floats: a contact slower than ``dead_speed`` holds ``applied`` up to ``static``."""
    if np.abs(v) > dead_speed:
        return level * np.sign(v)
    return min(max(applied, -static), static)
