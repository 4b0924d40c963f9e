"""Jacobians, singularities and the isotropic posture of the PepperMill-Carrier."""

import numpy as np
import pytest

from gapscope.models.pmc import kinematics, limits
from gapscope.models.pmc.geometry import Geometry

from .sampling import PROTOTYPE, working_joints


@pytest.mark.parametrize("geometry", [PROTOTYPE, Geometry(proximal=0.28, distal=0.33)])
def test_jacobian_is_the_derivative_of_the_forward_analysis(geometry):
    """Central differences with step h err by h^2 f'''/6 + eps |phi| / h: below 1e-5 of the phi row."""
    joints = working_joints(200, seed=11, geometry=geometry)
    poses = kinematics.forward(joints, geometry)
    exact = kinematics.jacobian(poses, joints, geometry)
    step = 1e-5
    for column in range(4):
        shift = np.zeros(4)
        shift[column] = step
        ahead, behind = (kinematics.forward(joints + s, geometry) for s in (shift, -shift))
        difference = (ahead - behind) / (2.0 * step)
        scale = np.abs(exact[:, :, column]) + 1.0
        assert (np.abs(difference - exact[:, :, column]) / scale).max() < 1e-6


def test_the_jacobians_are_inverse_to_each_other():
    joints = working_joints(1000, seed=12)
    poses = kinematics.forward(joints, PROTOTYPE)
    product = kinematics.jacobian(poses, joints, PROTOTYPE) @ kinematics.inverse_jacobian(
        poses, joints, PROTOTYPE
    )
    assert np.abs(product - np.eye(4)).max() < 1e-10


def test_the_isotropic_posture_is_isotropic():
    pose = kinematics.isotropic_pose(PROTOTYPE)
    joints = kinematics.inverse(pose, PROTOTYPE)
    assert joints == pytest.approx([0.3, 0.3, 0.0, np.pi / 2], abs=1e-12)
    assert kinematics.condition_number(pose, joints, PROTOTYPE) == pytest.approx(1.0, abs=1e-12)


def test_the_isotropic_posture_is_the_only_one():
    """Elsewhere on the working branch the condition number grows with the distance from it."""
    joints = working_joints(20_000, seed=13)
    poses = kinematics.forward(joints, PROTOTYPE)
    condition = kinematics.condition_number(poses, joints, PROTOTYPE)
    isotropic = kinematics.isotropic_pose(PROTOTYPE)
    away = np.abs(joints - kinematics.inverse(isotropic, PROTOTYPE)).max(axis=1)
    assert condition[away > 0.02].min() > 1.005


def test_singular_limits_are_singular():
    """At full reach the upper limit makes a distal link level and the lower one stretches the limb."""
    far = PROTOTYPE.carriage_max
    bound = limits.elevation_limits(PROTOTYPE)
    for alpha, kind in ((bound.singular_max, "parallel"), (bound.singular_min, "serial")):
        joints = np.array([far, far, alpha, np.pi / 2 - alpha])
        joints[:2] -= 1e-12  # from inside: the square root of the law is not differentiable there
        pose = kinematics.forward(joints, PROTOTYPE)
        distance = kinematics.singularities(pose, joints, PROTOTYPE)
        assert getattr(distance, kind) == pytest.approx(0.0, abs=1e-4)


def test_safe_limits_keep_both_margins_over_the_whole_stroke():
    """The margins bind at full reach, as the thesis assumes, and nowhere else."""
    joints = working_joints(100_000, seed=14)
    poses = kinematics.forward(joints, PROTOTYPE)
    distance = kinematics.singularities(poses, joints, PROTOTYPE)
    assert distance.parallel.min() > np.sin(np.radians(30.0))
    assert distance.serial.min() > np.sin(np.radians(30.0))
