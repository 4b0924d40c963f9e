"""Computed-torque controller: servo portion and inverse dynamics."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import LeafSystem

from ..models import control
from . import scalars
from .pd import gain_matrix


class ComputedTorque(LeafSystem):
    r"""Torque :math:`\tau = M(\ddot\psi_d + K_P e + K_D \dot e) + c D \tilde{\dot\psi}`.

    Friedlaender 2015, eqs. (4.33)-(4.35) and Fig. 4-2.

    | port | size | unit |
    |---|---|---|
    | in  `acceleration` | n | rad/s^2, of the reference |
    | in  `error`        | n | rad |
    | in  `error_rate`   | n | rad/s, from a ``FilteredDerivative`` |
    | in  `rate`         | n | rad/s, from a ``RateObserver`` |
    | out `torque`       | n | N m |

    No state. Numeric parameters, all (n, n): ``KP`` [1/s^2], ``KD`` [1/s] (a number stands for that
    multiple of the unit matrix), ``INERTIA`` M [kg m^2] and ``DAMPING`` c D [N m s/rad] as the
    controller believes them to be. Raises ValueError if a matrix has another shape.
    """

    KP, KD, INERTIA, DAMPING = range(4)

    def __init__(
        self, *, kp: ArrayLike, kd: ArrayLike, inertia: ArrayLike, damping: ArrayLike
    ) -> None:
        LeafSystem.__init__(self)
        self.size = len(np.asarray(inertia))
        for matrix in (kp, kd, inertia, damping):
            scalars.declare_parameter(self, gain_matrix(matrix, self.size))
        for name in ("acceleration", "error", "error_rate", "rate"):
            self.DeclareVectorInputPort(name, self.size)
        self.DeclareVectorOutputPort("torque", self.size, self._torque)

    def _torque(self, context: Any, output: Any) -> None:
        n = self.size
        kp, kd, inertia, damping = (scalars.parameter(context, p, n, n) for p in range(4))
        output.SetFromVector(servo_torque(self, context, kp, kd, inertia, damping))


def servo_torque(
    system: LeafSystem, context: Any, kp: Any, kd: Any, inertia: Any, damping: Any
) -> list[float]:
    """Eq. (4.35) from the four input ports of a model-based controller."""
    acceleration, error, slope, rate = (
        scalars.signal(system, context, name)
        for name in ("acceleration", "error", "error_rate", "rate")
    )
    n = len(error)
    none = np.zeros((n, n))
    corrected = [
        acceleration[i] + control.pid(i, kp, none, kd, error, none[i], slope) for i in range(n)
    ]
    return [control.inverse_dynamics(i, inertia, damping, corrected, rate) for i in range(n)]
