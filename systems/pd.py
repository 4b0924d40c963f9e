"""Joint-space PD controller."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from pydrake.systems.framework import LeafSystem

from ..models import leaf_kernels
from . import scalars


class PD(LeafSystem):
    r"""Torque :math:`\tau = K_P e + K_D \dot e`  (Friedlaender 2015, eq. 4.32 without the integral).

    | port | size | unit |
    |---|---|---|
    | in  `error`      | n | rad |
    | in  `error_rate` | n | rad/s, from a ``FilteredDerivative`` |
    | out `torque`     | n | N m |

    No state. Numeric parameters ``KP`` [N m/rad] and ``KD`` [N m s/rad], full (n, n) matrices;
    a number stands for that multiple of the unit matrix.
    """

    KP, KD = range(2)

    def __init__(self, size: int, *, kp: ArrayLike, kd: ArrayLike) -> None:
        LeafSystem.__init__(self)
        self.size, self._no_integral = size, np.zeros(size * size)
        for gain in (kp, kd):
            scalars.declare_parameter(self, gain_matrix(gain, size))
        self.DeclareVectorInputPort("error", size)
        self.DeclareVectorInputPort("error_rate", size)
        self.DeclareVectorOutputPort("torque", size, self._torque)

    def _torque(self, context: Any, output: Any) -> None:
        leaf_kernels.pid(
            scalars.constants(context, self.KP),
            self._no_integral,
            scalars.constants(context, self.KD),
            scalars.numbered(self, context, 0),
            self._no_integral[: self.size],
            scalars.numbered(self, context, 1),
            output.get_mutable_value(),
        )


def gain_matrix(gain: ArrayLike, size: int) -> Any:
    """``gain`` as an (n, n) matrix; a number becomes that multiple of the unit matrix."""
    values = np.asarray(gain, dtype=float)
    if values.shape not in ((), (size, size)):
        raise ValueError(
            f"gain has the shape {values.shape}; expected a number or ({size}, {size})"
        )
    return values * np.eye(size) if values.ndim == 0 else values
