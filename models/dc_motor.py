r"""Direct-current motor with its winding, and what a gear or a screw makes of its shaft (Roldan, section 3.2).

1. winding (3.1, 3.2): :math:`L\, di/dt = V - R i - K_E \dot\theta`, :math:`\tau = K_t i`
2. transfer (3.3): :math:`I/(V - E) = 1/(L s + R)`
3. gear (3.27): :math:`i_R = 1/i_r`; guide (3.28): :math:`i_R = p/(2 \pi i_r)`, m/rad
4. gains of a sampled current loop, voltage held for T: :math:`k_I = R(1 - e^{-\omega T})/T`,
   :math:`k_P = k_I T/(1 - e^{-RT/L})`. Its zero cancels the winding's pole; the loop's pole is :math:`e^{-\omega T}`.

Not modelled: saturation of the iron, cogging, commutation. Units: V, A, ohm, H, rad/s, N m.
"""

from dataclasses import dataclass
from math import expm1, pi
from typing import Any

from .transmission import Transfer


@dataclass(frozen=True, kw_only=True)
class DCMotor:
    """Raises ValueError for a value that is not positive."""

    resistance: float  # R [ohm]
    inductance: float  # L [H]
    torque_constant: float  # K_t [N m/A]
    emf_constant: float  # K_E [V s/rad]

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if not value > 0.0:
                raise ValueError(f"{name} is {value}; expected a value above 0")

    @property
    def electric_transfer(self) -> Transfer:
        """Current per voltage across the winding (2) [A/V]."""
        return Transfer((1.0,), (self.inductance, self.resistance))


def winding_rate(
    current: Any, voltage: Any, speed: Any, resistance: Any, inductance: Any, emf_constant: Any
) -> Any:
    """Rate of the current [A/s] by (1)."""
    return (voltage - resistance * current - emf_constant * speed) / inductance


def current_gains(motor: DCMotor, bandwidth: float, period: float) -> tuple[float, float]:
    """k_P [V/A] and k_I [V/(A s)] by (4): at its samples the current follows as a lag of ``bandwidth`` [rad/s] does.

    ``period`` T [s]. Raises ValueError unless both are positive.
    """
    if not (bandwidth > 0.0 and period > 0.0):
        raise ValueError(
            f"bandwidth is {bandwidth} and period is {period}; expected values above 0"
        )
    ki = -motor.resistance * expm1(-bandwidth * period) / period
    return -ki * period / expm1(-motor.resistance * period / motor.inductance), ki


def joint_per_motor(gear_ratio: float, lead: float | None = None) -> float:
    """Joint motion per motor angle (3): rad/rad, or m/rad on a guide of ``lead`` [m/rev].

    The same factor turns a joint force into the torque it puts on the motor. ValueError unless positive.
    """
    if not gear_ratio > 0.0 or (lead is not None and not lead > 0.0):
        raise ValueError(f"gear ratio is {gear_ratio} and lead is {lead}; expected values above 0")
    return 1.0 / gear_ratio if lead is None else lead / (2.0 * pi * gear_ratio)
