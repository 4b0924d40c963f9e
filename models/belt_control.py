"""Cascaded control assumed of the 2PRU-1PRS table's axes, whose gains are not printed (Roldan, section 4.2.4)."""

from dataclasses import dataclass

import numpy as np

from .belt_axis import BeltAxis
from .servo_kernels import Loops


@dataclass(frozen=True, kw_only=True)
class Gains:
    """What is assumed of the controller: no gain of it is printed for the table.

    Sample times are those printed for the 3-PRS, whose computer, drives and motors are the same. k_v and both values of
    the speed loop were fitted to the six printed gains and phases, in a z motion of 4 mm. The five-bar's printed speed
    loop has 154 rad/s and a corner of 82 rad/s.
    """

    position_gain: float = 21.5  # k_v [1/s]
    position_period: float = 5e-3  # of the 3-PRS [s]
    velocity_period: float = 1e-3  # of the 3-PRS [s]
    velocity_bandwidth: float = 82.0  # of the speed loop on the axis alone [rad/s]
    integral_corner: float = 75.0  # k_I/k_P of the speed loop [rad/s]

    def loops(self, axis: BeltAxis) -> Loops:
        """Gains for an axis tuned by the manufacturers' inertias."""
        kp = self.velocity_bandwidth * (axis.driving + axis.driven) / axis.torque_constant
        ratio = round(self.position_period / self.velocity_period)
        return Loops(
            self.position_gain,
            0.0,
            0.0,
            kp,
            self.integral_corner * kp,
            np.inf,
            self.velocity_period,
            ratio,
        )
