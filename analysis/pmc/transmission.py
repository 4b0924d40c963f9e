r"""How the PepperMill-Carrier carries forces and errors between the motors and the gripper.

1. A wrench :math:`(F_x, F_y, F_z, M_\phi)` on the PM loads the joints by :math:`J^T`; the C-drive turns a carriage
   force and a drive torque into two motor torques by the transpose of (2.1).
2. A drive error :math:`\delta\theta_i` turns the PM by :math:`g_i/(2p)\,\delta\theta_i`: the screws that let the
   PM turn twice amplify it.

Forces in N, torques in N m, motor order (L1, R1, L2, R2). Friction is left out: statics only.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...models import c_drive
from ...models.pmc import kinematics
from ...models.pmc.geometry import Geometry

Floats = NDArray[np.float64]


def motor_torques(
    wrenches: ArrayLike, poses: ArrayLike, joints: ArrayLike, geometry: Geometry, lead: float
) -> Floats:
    """Motor torques (..., 4) that hold wrenches (..., 4) on the PM, law (1); ``lead`` of the C-drives [m/rev]."""
    loads = np.einsum(
        "...ij,...i->...j", kinematics.jacobian(poses, joints, geometry), np.asarray(wrenches)
    )
    per_v = 2.0 * np.pi / lead
    to_motors = c_drive.jacobian(lead)
    drives = [
        np.stack([-loads[..., i], -per_v * loads[..., i + 2]], axis=-1) @ to_motors for i in (0, 1)
    ]
    return np.concatenate(drives, axis=-1)


def turning_torque(poses: ArrayLike, joints: ArrayLike, geometry: Geometry, lead: float) -> Floats:
    """Largest motor torque per torque about the PM axis [-]."""
    unit = np.broadcast_to([0.0, 0.0, 0.0, 1.0], np.shape(poses))
    return np.abs(motor_torques(unit, poses, joints, geometry, lead)).max(axis=-1)


def turning_error(poses: ArrayLike, joints: ArrayLike, geometry: Geometry) -> Floats:
    """PM rotation per error of one drive angle, the larger of the two [rad/rad], law (2)."""
    return np.abs(kinematics.jacobian(poses, joints, geometry)[..., 3, 2:]).max(axis=-1)
