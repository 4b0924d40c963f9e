"""The MM3A as a MultibodyPlant on a tilted base."""

from pydrake.math import RigidTransform, RotationMatrix
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from ...models.mm3a.arm import Arm
from ...models.mm3a.sdf import sdf


def add_arm(
    plant: MultibodyPlant, arm: Arm | None = None, theta: float = 0.0, psi: float = 0.0
) -> None:
    """Add the arm to an unfinalized ``plant``, base welded with R_WB = R_x(theta) R_y(psi) [rad].

    Position order is joint_1, joint_2, joint_3; the tip is the origin of body ``link_3``.
    """
    Parser(plant).AddModelsFromString(sdf(arm or Arm()), "sdf")
    tilt = RotationMatrix.MakeXRotation(theta) @ RotationMatrix.MakeYRotation(psi)
    plant.WeldFrames(
        plant.world_frame(), plant.GetFrameByName("base"), RigidTransform(tilt, [0.0, 0.0, 0.0])
    )
