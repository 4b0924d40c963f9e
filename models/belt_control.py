"""Cascaded control assumed of the 2PRU-1PRS table's axes, whose gains are not printed (Roldan, section 4.2.4)."""

from dataclasses import dataclass

import numpy as np

from .belt_axis import BeltAxis
from .servo_kernels import Loops


@dataclass(frozen=True, kw_only=True)
class Gains:
    """What is assumed of the controller: nothing of it is printed for the table.

    The printed gains and phases, inverted, ask for an open loop of 22.6-23.0 1/s at 0.4, 5 and 10 Hz behind a lag of
    7-10 ms: a gain k_v and half a sample of a slow position loop. k_v and its period were chosen on a grid for the
    smallest difference from the six printed numbers.
    """

    position_gain: float = 24.0  # k_v [1/s]
    position_period: float = 0.015  # [s]
    velocity_period: float = 1e-3  # [s]
    velocity_bandwidth: float = 600.0  # of the speed loop on the axis alone [rad/s]
    integral_corner: float = 20.0  # k_I/k_P of the speed loop [rad/s]

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
