r"""Motor, gear and friction of one rigid servo axis (Roldan, section 4.1.2).

.. math:: J_t \ddot\theta = K_t i - \tau_f(\dot\theta) - i_R f, \qquad \tau_f = c\dot\theta + F_c\tanh(\beta\dot\theta)

(4.9, 4.10), with the joint's motion :math:`q = i_R\theta` and the load f of the machine on the joint. The current
loop counts as instantaneous, as in section 4.1.3. Motor side in rad, N m, A; laws take floats and arrays.
"""

from dataclasses import dataclass
from typing import Any

from . import friction
from .dc_motor import joint_per_motor


@dataclass(frozen=True, kw_only=True)
class ServoAxis:
    """One axis; defaults are Table 4.1. Raises ValueError for a value out of range."""

    inertia: float = 13e-4  # J_t, motor and gearbox, at the motor [kg m^2]
    viscous: float = 1.7e-3  # c [N m s/rad]
    coulomb: float = 0.478  # F_c [N m]
    sign_rate: float = 10.78  # beta, printed without a unit [s/rad]
    torque_constant: float = 1.43  # K_t [N m/A]
    per_motor: float = joint_per_motor(40.0)  # i_R, joint motion per motor angle

    def __post_init__(self) -> None:
        for name in ("inertia", "sign_rate", "torque_constant", "per_motor"):
            if not getattr(self, name) > 0.0:
                raise ValueError(f"{name} is {getattr(self, name)}; expected a value above 0")
        if min(self.viscous, self.coulomb) < 0.0:
            raise ValueError("viscous or coulomb is negative; expected values of at least 0")

    @property
    def joint_inertia(self) -> float:
        """The axis as felt at its joint [kg m^2, or kg on a guide]."""
        return self.inertia / self.per_motor**2

    def friction(self, motor_rate: Any) -> Any:
        """Friction torque at the motor [N m], (4.10)."""
        return friction.sech_dry(motor_rate, self.viscous, self.coulomb, 0.0, 0.0, self.sign_rate)

    def net_torque(self, motor_rate: Any, current: Any) -> Any:
        """Torque at the motor that is left to move motor and machine [N m]."""
        return self.torque_constant * current - self.friction(motor_rate)

    def motor_acceleration(self, motor_rate: Any, current: Any, load: Any) -> Any:
        """Motor acceleration [rad/s^2] under the machine's load on the joint [N m or N]."""
        net = self.net_torque(motor_rate, current)
        return (net - self.per_motor * load) / self.inertia
