"""Forward kinematics of the MM3A as a system."""

from typing import Any

from pydrake.systems.framework import BasicVector, LeafSystem

from ...models.mm3a import kinematics
from ...models.mm3a.arm import Arm


class TipPosition(LeafSystem):
    """p = FK(q), eq. (A.2).

    | port | size | unit |
    |---|---|---|
    | in  `joints` | 3 | rad, rad, m |
    | out `tip`    | 3 | m, in frame 0 |

    No state, no assumption on limits.
    """

    def __init__(self, arm: Arm | None = None) -> None:
        super().__init__()
        self._arm = arm or Arm()
        self._joints = self.DeclareVectorInputPort("joints", BasicVector(3))
        self.DeclareVectorOutputPort("tip", 3, self._calc_tip, {self._joints.ticket()})

    def _calc_tip(self, context: Any, output: Any) -> None:
        output.SetFromVector(kinematics.tip(self._joints.Eval(context), self._arm))
