"""PD controller with gains for the collar's translation and rotation."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models import control
from ..models.c_drive_controllers import task_gain
from . import scalars


class TaskSpacePD(LeafSystem):
    r"""Torque :math:`\tau = J^{-1} K_P J e + J^{-1} K_D J \dot e`  (Friedlaender 2015, eq. 4.37a).

    | port | size | unit |
    |---|---|---|
    | in  `error`      | 2 | rad, motors (L, R) |
    | in  `error_rate` | 2 | rad/s, from a ``FilteredDerivative`` |
    | out `torque`     | 2 | N m, motors (L, R) |

    No state. Numeric parameters ``KP`` [N m/rad] and ``KD`` [N m s/rad]: (translation, rotation), and
    ``LEAD``: p_c [m/rev], positive. Equal gains make it the joint-space ``PD`` (4.38). Whatever the
    lead, J^-1 K J is the same symmetric matrix: J is a multiple of a rotation.
    """

    KP, KD, LEAD = range(3)

    def __init__(self, *, kp: tuple[float, float], kd: tuple[float, float], lead: float) -> None:
        LeafSystem.__init__(self)
        for values in (kp, kd, [scalars.positive(self, "lead", lead, "m/rev")]):
            scalars.declare_parameter(self, values)
        self.DeclareVectorInputPort("error", 2)
        self.DeclareVectorInputPort("error_rate", 2)
        self.DeclareVectorOutputPort("torque", 2, self._torque)

    def _torque(self, context: Any, output: Any) -> None:
        lead = context.get_numeric_parameter(self.LEAD)[0]
        kp, kd = (scalars.parameter(context, gain, 2) for gain in (self.KP, self.KD))
        kp, kd = task_gain(kp[0], kp[1], lead), task_gain(kd[0], kd[1], lead)
        error = scalars.signal(self, context, "error")
        slope = scalars.signal(self, context, "error_rate")
        none = np.zeros((2, 2))
        output.SetFromVector(
            [control.pid(i, kp, none, kd, error, none[i], slope) for i in range(2)]
        )
