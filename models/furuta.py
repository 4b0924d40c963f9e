r"""Rotary inverted pendulum: an arm turned by a DC motor carries a pendulum on its tip (Furuta).

1. :math:`M = \begin{pmatrix} J + P\sin^2\alpha & C\cos\alpha \\ C\cos\alpha & P \end{pmatrix}`
2. :math:`h = \begin{pmatrix} 2 P \sin\alpha\cos\alpha\,\dot\theta\dot\alpha - C\sin\alpha\,\dot\alpha^2 \\
   -P\sin\alpha\cos\alpha\,\dot\theta^2 - G\sin\alpha \end{pmatrix}`
3. :math:`M (\ddot\theta, \ddot\alpha)^T + h = (\tau - D_r\dot\theta, -D_p\dot\alpha)^T`
4. :math:`\tau = k (u - k\dot\theta) / R`, a DC motor without inductance, volts to N m

Arm angle :math:`\theta` and pendulum angle :math:`\alpha`, which is 0 upright and turns such that the tip
leans towards positive :math:`\theta`. :math:`J = J_r + J_m + m L_r^2`, :math:`P = J_p + m l^2`,
:math:`C = m l L_r`, :math:`G = m g l` with the pendulum's centre at half its length, l. Source: Fantoni and
Lozano 2002, ch. 7; numbers as Quanser prints them for the QUBE-Servo 2 (rotary pendulum laboratory,
``qube2_rotpen_param.m``, and the motor's data sheet). Not modelled here: dry friction, inductance, the
encoder's cable.
"""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np

G = 9.81  # [m/s^2]
GROUPS = ("J", "P", "C", "G")  # of parameters that the equations are linear in


@dataclass(frozen=True, kw_only=True)
class FurutaParameters:
    """Constants of a rotary pendulum; defaults are Quanser's for the QUBE-Servo 2."""

    R: float = 8.4  # terminal resistance [ohm]
    k: float = 0.042  # torque and back-EMF constant [N m/A, V s/rad]
    J_m: float = 4.6e-6  # rotor 4.0e-6 and hub 0.6e-6 [kg m^2]
    J_r: float = 0.095 * 0.085**2 / 12.0  # arm [kg m^2], printed as "about pivot"
    L_r: float = 0.085  # arm length [m]
    m: float = 0.024  # pendulum [kg]
    L_p: float = 0.129  # pendulum length [m]
    J_p: float = 0.024 * 0.129**2 / 12.0  # pendulum about its centre [kg m^2]
    D_r: float = 0.0015  # damping of the arm's axis [N m s/rad]
    D_p: float = 0.0005  # damping of the pendulum's axis [N m s/rad]

    def __post_init__(self) -> None:
        """Refuse numbers without meaning."""
        for field in fields(self):
            value = getattr(self, field.name)
            if not np.isfinite(value) or value < 0.0 or (value == 0.0 and field.name[0] != "D"):
                raise ValueError(f"{field.name} is {value!r}; a positive number is expected")

    @property
    def groups(self) -> tuple[float, float, float, float]:
        """J, P, C [kg m^2] and G [N m]."""
        l = 0.5 * self.L_p  # noqa: E741 - the source's symbol
        return (
            self.J_r + self.J_m + self.m * self.L_r**2,
            self.J_p + self.m * l * l,
            self.m * l * self.L_r,
            self.m * G * l,
        )


def mass_matrix(alpha: Any, J: Any, P: Any, C: Any) -> tuple[Any, Any, Any]:
    """M11, M12, M22 of equation (1) [kg m^2]."""
    s, c = np.sin(alpha), np.cos(alpha)
    return J + P * s * s, C * c, P + 0.0 * c


def bias(alpha: Any, theta_rate: Any, alpha_rate: Any, P: Any, C: Any, G: Any) -> tuple[Any, Any]:
    """Velocity and gravity terms h1, h2 of equation (2) [N m]."""
    s, c = np.sin(alpha), np.cos(alpha)
    return (
        2.0 * P * s * c * theta_rate * alpha_rate - C * s * alpha_rate * alpha_rate,
        -P * s * c * theta_rate * theta_rate - G * s,
    )


def equation_columns(q: Any, v: Any) -> tuple[Any, Any, Any]:
    """Mass matrices (S, 4, 2, 2), bias efforts and gravity loads (S, 4, 2) per unit of ``GROUPS``.

    ``q`` and ``v`` (S, 2) are arm and pendulum angles [rad] and rates [rad/s].
    """
    samples = len(q)
    M, h, load = np.zeros((samples, 4, 2, 2)), np.zeros((samples, 4, 2)), np.zeros((samples, 4, 2))
    zero = np.zeros(samples)
    for k, unit in enumerate(np.eye(4)):
        J, P, C, g = unit
        m11, m12, m22 = mass_matrix(q[:, 1], J, P, C)
        M[:, k, 0, 0], M[:, k, 0, 1], M[:, k, 1, 0], M[:, k, 1, 1] = m11, m12, m12, m22
        h[:, k] = np.column_stack(bias(q[:, 1], v[:, 0], v[:, 1], P, C, g))
        load[:, k] = np.column_stack(bias(q[:, 1], zero, zero, P, C, g))
    return M, h, load
