"""Source of the PepperMill-Carrier's test cycles."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models.pmc import displacement
from ..models.pmc.cycle import IndustryCycle, LameCycle
from ..models.pmc.geometry import Geometry

PORTS = ("joints", "joint_acceleration", "pose", "pose_acceleration")


class CycleSource(LeafSystem):
    """A test cycle and the joint motion that produces it (2.8, 2.13 and ``displacement.joint_motion``).

    | port | size | unit |
    |---|---|---|
    | out `joints`             | 4 | m, m, rad, rad |
    | out `joint_acceleration` | 4 | per s^2 |
    | out `pose`               | 4 | m, m, m, rad: x, y, z, phi in W |
    | out `pose_acceleration`  | 4 | per s^2 |

    No state; functions of time. Assumes that the cycle stays in the working mode and in reach: outputs are NaN
    outside.
    """

    def __init__(self, cycle: IndustryCycle | LameCycle, geometry: Geometry) -> None:
        LeafSystem.__init__(self)
        self.cycle = cycle
        self.dimensions = geometry.dimensions
        for index, name in enumerate(PORTS):
            self.DeclareVectorOutputPort(
                name, 4, self._output(index), prerequisites_of_calc={self.time_ticket()}
            )

    def _output(self, index: int) -> Any:
        def calc(context: Any, output: Any) -> None:
            pose, rate, acceleration = self.cycle.sample(context.get_time())
            joints, _, joint_acceleration = displacement.joint_motion(
                pose, rate, acceleration, self.dimensions
            )
            output.SetFromVector(
                np.asarray((joints, joint_acceleration, pose, acceleration)[index])
            )

        return calc
