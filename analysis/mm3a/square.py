"""A square of a tenth of a millimetre, drawn open-loop: the steps seen at their own scale."""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ...models.mm3a import kinematics, open_loop, stepper
from ...models.mm3a.arm import Arm
from ...models.mm3a.step_size import StepModel, constant_steps
from .positioning import SPEED, START

SIDE = 100e-6  # [m]


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """Joints after every tick, and the tip positions wanted there."""

    wanted: NDArray[np.float64]  # (n, 3) in frame 0 [m]
    joints: dict[str, NDArray[np.float64]]  # by believed model, (n + 1, 3)

    def tips(self, name: str) -> NDArray[np.float64]:
        """Tip positions (n + 1, 3) in frame 0 [m]."""
        return np.array([kinematics.tip(q, Arm()) for q in self.joints[name]])


def draw_square(side: float = SIDE, speed: float = SPEED) -> Drawing:
    """Re-plan a square in the x-z plane with the true step model and with the constant step."""
    corner = np.array(kinematics.tip(START, Arm()))
    corners = corner + side * np.array([[0, 0, 0], [1, 0, 0], [1, 0, 1], [0, 0, 1], [0, 0, 0]])
    wanted = np.vstack([open_loop.straight_path(a, b, speed) for a, b in pairwise(corners)])
    joints = {}
    for name, model in (
        ("step model", StepModel()),
        ("constant step", constant_steps(StepModel())),
    ):
        commands, _ = open_loop.follow(wanted, START, model=model)
        joints[name] = stepper.run(commands, START).positions
    return Drawing(wanted=wanted, joints=joints)
