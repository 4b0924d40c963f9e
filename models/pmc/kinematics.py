r"""Kinematics of the PepperMill-Carrier over arrays of poses or joints, compiled.

Last axis 4: poses (x, y, z [m], phi [rad]) and joints (d1, d2 [m], theta1, theta2 [rad]). Frames, laws and
sources stand in the package's docstring and in ``displacement``.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import compilation
from . import displacement, limb
from .geometry import Geometry

Floats = NDArray[np.float64]

compilation.register_laws(limb, displacement)


@dataclass(frozen=True)
class Mode:
    """One posture (inverse) or branch (forward): the side of the elbow, or of the wrist, by limb.

    +1 is up and -1 down (Table 2-1). Raises ValueError for any other value.
    """

    limb1: int
    limb2: int

    def __post_init__(self) -> None:
        if self.limb1 not in (-1, 1) or self.limb2 not in (-1, 1):
            raise ValueError(
                f"mode is ({self.limb1}, {self.limb2}); expected +1 (up) or -1 (down) for each limb"
            )


MODES = (Mode(1, 1), Mode(1, -1), Mode(-1, 1), Mode(-1, -1))
ELBOWS_UP = Mode(1, 1)  # working posture of the prototype
FOREARMS_DOWN = Mode(-1, -1)  # working branch of the prototype


def inverse(poses: ArrayLike, geometry: Geometry, posture: Mode = ELBOWS_UP) -> Floats:
    """Joints of ``poses`` (..., 4) in one of the four postures; a row out of reach is NaN."""
    rows, shape = _rows(poses, "poses")
    _inverse(rows, posture.limb1, posture.limb2, geometry.dimensions, rows)
    return rows.reshape(shape)


def forward(joints: ArrayLike, geometry: Geometry, branch: Mode = FOREARMS_DOWN) -> Floats:
    """Poses of ``joints`` (..., 4) in one of the four branches; a row out of reach is NaN."""
    rows, shape = _rows(joints, "joints")
    _forward(rows, branch.limb1, branch.limb2, geometry.dimensions, rows)
    return rows.reshape(shape)


def link_elevations(poses: ArrayLike, joints: ArrayLike, geometry: Geometry) -> Floats:
    """Elevations (alpha1, beta1, alpha2, beta2) of the links [rad], (..., 4)."""
    pose_rows, shape = _rows(poses, "poses")
    joint_rows, _ = _rows(joints, "joints")
    _elevations(pose_rows, joint_rows, geometry.dimensions, pose_rows)
    return pose_rows.reshape(shape)


def jacobian(poses: ArrayLike, joints: ArrayLike, geometry: Geometry) -> Floats:
    """Velocity Jacobian (..., 4, 4) from joint rates to pose rates at closed postures.

    Rows x, y, z, phi; columns d1, d2, theta1, theta2. Not finite at parallel singularities.
    """
    pose_rows, shape = _rows(poses, "poses")
    joint_rows, _ = _rows(joints, "joints")
    out = np.zeros((len(pose_rows), 4, 4))
    _jacobian(pose_rows, joint_rows, geometry.dimensions, out)
    return out.reshape(*shape, 4)


def inverse_jacobian(poses: ArrayLike, joints: ArrayLike, geometry: Geometry) -> Floats:
    """Velocity Jacobian (..., 4, 4) from pose rates to joint rates at closed postures.

    Not finite at serial singularities.
    """
    pose_rows, shape = _rows(poses, "poses")
    joint_rows, _ = _rows(joints, "joints")
    out = np.zeros((len(pose_rows), 4, 4))
    _inverse_jacobian(pose_rows, joint_rows, geometry.dimensions, out)
    return out.reshape(*shape, 4)


@dataclass(frozen=True, kw_only=True)
class Singularities:
    """Distance from the two kinds of singularity by limb, each in [0, 1], 0 at the singularity.

    ``serial`` (..., 2) is the sine of the angle between a limb's links, ``parallel`` (..., 2) the sine of the
    slope of its distal link.
    """

    serial: Floats
    parallel: Floats


def singularities(poses: ArrayLike, joints: ArrayLike, geometry: Geometry) -> Singularities:
    """How far closed postures are from the singularities of each limb."""
    links = link_elevations(poses, joints, geometry)
    alpha, beta = links[..., 0::2], links[..., 1::2]
    return Singularities(serial=np.abs(np.sin(beta - alpha)), parallel=np.abs(np.sin(beta)))


def condition_number(poses: ArrayLike, joints: ArrayLike, geometry: Geometry) -> Floats:
    r"""2-norm condition number of the Jacobian made homogeneous, at least 1; infinite if singular.

    Angles become lengths by :math:`p` (screw) and :math:`r/\sqrt2` (drives), the only lengths for which an
    isotropic posture exists.
    """
    scaled = jacobian(poses, joints, geometry)
    scaled[..., 3, :] *= geometry.pitch
    scaled[..., :, 2:] /= geometry.proximal / np.sqrt(2.0)
    regular = np.asarray(np.isfinite(scaled)).all(axis=(-2, -1))
    condition = np.full(regular.shape, np.inf)
    condition[regular] = np.linalg.cond(scaled[regular])
    return condition


def isotropic_pose(geometry: Geometry) -> Floats:
    """The one isotropic pose of the working branch: proximal links level, distal links hanging.

    Isotropy needs cot(beta) = 0 (x and y decoupled from z and phi) and |g| = r, hence alpha = 0: the wrists
    at reach r and height -l, and the PM centred (3.5).
    """
    reach = geometry.proximal
    return np.array([reach, reach, -geometry.distal, geometry.centre_angle])


def _rows(values: ArrayLike, what: str) -> tuple[Floats, tuple[int, ...]]:
    rows = np.array(values, dtype=float)
    if rows.ndim == 0 or rows.shape[-1] != 4:
        raise ValueError(f"{what} have shape {rows.shape}; expected a last axis of 4")
    return np.ascontiguousarray(rows.reshape(-1, 4)), rows.shape


@compilation.kernel
def _inverse(poses: Any, elbow1: Any, elbow2: Any, dim: Any, out: Any) -> None:
    for i in range(poses.shape[0]):
        pose = (poses[i, 0], poses[i, 1], poses[i, 2], poses[i, 3])
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = displacement.joints(pose, elbow1, elbow2, dim)
        if np.isnan(out[i, 2] + out[i, 3]):
            out[i, :] = np.nan


@compilation.kernel
def _forward(joints: Any, fore1: Any, fore2: Any, dim: Any, out: Any) -> None:
    for i in range(joints.shape[0]):
        joint = (joints[i, 0], joints[i, 1], joints[i, 2], joints[i, 3])
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = displacement.pose(joint, fore1, fore2, dim)
        if np.isnan(out[i, 2] + out[i, 3]):
            out[i, :] = np.nan


@compilation.kernel
def _elevations(poses: Any, joints: Any, dim: Any, out: Any) -> None:
    for i in range(poses.shape[0]):
        pose = (poses[i, 0], poses[i, 1], poses[i, 2], poses[i, 3])
        out[i, 0], out[i, 1], out[i, 2], out[i, 3] = displacement.elevations(pose, joints[i], dim)


@compilation.kernel
def _jacobian(poses: Any, joints: Any, dim: Any, out: Any) -> None:
    for i in range(poses.shape[0]):
        pose = (poses[i, 0], poses[i, 1], poses[i, 2], poses[i, 3])
        a1, g1, a2, g2 = displacement.wrist_gradients(pose, joints[i], dim)
        out[i, 0, 0] = 1.0
        out[i, 1, 1] = 1.0
        out[i, 2] = 0.5 * np.array([a2, a1, g1, g2])
        out[i, 3] = 0.5 / dim.pitch * np.array([-a2, a1, g1, -g2])


@compilation.kernel
def _inverse_jacobian(poses: Any, joints: Any, dim: Any, out: Any) -> None:
    for i in range(poses.shape[0]):
        pose = (poses[i, 0], poses[i, 1], poses[i, 2], poses[i, 3])
        a1, g1, a2, g2 = displacement.wrist_gradients(pose, joints[i], dim)
        out[i, 0, 0] = 1.0
        out[i, 1, 1] = 1.0
        out[i, 2] = np.array([0.0, -a1, 1.0, dim.pitch]) / g1
        out[i, 3] = np.array([-a2, 0.0, 1.0, -dim.pitch]) / g2
