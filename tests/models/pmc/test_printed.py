"""Numbers printed in chapters 2 and 3 of Friedlaender 2015, and the misprints among its equations."""

import numpy as np
import pytest

from gapscope.models import c_drive, motion
from gapscope.models.pmc import kinematics, limits
from gapscope.models.pmc.geometry import Geometry

from .sampling import PROTOTYPE, distance, working_joints

R, B0, P = PROTOTYPE.proximal, PROTOTYPE.spacing, PROTOTYPE.pitch


def test_elevation_limits():
    """Eqs. (2.22)-(2.25), to the digits printed."""
    bound = limits.elevation_limits(PROTOTYPE)
    assert bound.singular_max == pytest.approx(1.21, abs=0.005)
    assert np.degrees(bound.singular_max) == pytest.approx(69.1, abs=0.05)
    assert bound.safe_max == pytest.approx(1.058, abs=0.0005)
    assert bound.singular_min == pytest.approx(-0.825, abs=0.0005)
    assert bound.safe_min == pytest.approx(-0.530, abs=0.0005)


def test_limits_of_the_second_limb_mirror_those_of_the_first():
    """Eq. (2.19)."""
    (low1, high1), (low2, high2) = limits.theta_bounds(PROTOTYPE)
    assert (low2, high2) == pytest.approx((np.pi / 2 - high1, np.pi / 2 - low1))


def test_unreachable_limits_are_refused():
    with pytest.raises(ValueError, match="no limit posture"):
        limits.elevation_limits(Geometry(proximal=0.15, distal=0.2))
    with pytest.raises(ValueError, match="leave no elevation"):
        limits.elevation_limits(Geometry(distal_margin=1.2, fold_margin=1.4))


def test_screw_range():
    """Eqs. (2.20)-(2.21): they follow from (3.5) and two turns."""
    assert PROTOTYPE.centre_angle == pytest.approx(-122.0 / 5.0 * np.pi)
    assert PROTOTYPE.angle_max == pytest.approx(-112.0 / 5.0 * np.pi)
    assert PROTOTYPE.angle_min == pytest.approx(-132.0 / 5.0 * np.pi)


def test_stroke_leaves_the_printed_margin():
    """Section 3.2: 300 mm on the diagonal of the square need 212 mm of the 216 mm stroke."""
    stroke = PROTOTYPE.carriage_max - PROTOTYPE.carriage_min
    assert stroke == pytest.approx(0.216)
    assert stroke - 0.300 / np.sqrt(2.0) == pytest.approx(0.004, abs=2e-4)


def closed_form_2_13(pose):
    """Eqs. (2.13a-c) as printed; angles in (-2 pi, 2 pi]."""
    x, y, z, phi = pose.T
    p1, p2 = z + B0 + P * phi, z - B0 - P * phi

    def root(h, v):
        return 0.5 * np.sqrt(4.0 * h**2 + 4.0 * v**2 - ((h**2 + v**2) / R) ** 2)

    theta1 = 2.0 * np.arctan2(-p1 - root(y, p1), -(y**2 + p1**2) / (2.0 * R) - y)
    theta2 = 2.0 * np.arctan2(-x + root(x, p2), -(x**2 + p2**2) / (2.0 * R) - p2)
    return np.column_stack([x, y, theta1, theta2])


def test_closed_form_2_13_agrees_and_needs_wrapping():
    joints = working_joints(10_000, seed=21)
    poses = kinematics.forward(joints, PROTOTYPE)
    printed = closed_form_2_13(poses)
    assert distance(printed, joints) < 1e-6
    outside = (np.abs(printed[:, 2:]) > np.pi).any(axis=1)
    assert outside.any()
    wrapped = kinematics.inverse(poses, PROTOTYPE)[:, 2:]
    assert (np.abs(wrapped) <= np.pi).all()


def test_ours_is_accurate_where_2_13_cancels():
    """Near the isotropic posture (2.13a) is 0/0-like: -P1z - root and C - A both vanish or cancel."""
    pose = kinematics.isotropic_pose(PROTOTYPE) + np.array([0.0, 1e-9, 1e-9, 0.0])
    again = kinematics.forward(kinematics.inverse(pose, PROTOTYPE), PROTOTYPE)
    assert np.abs(again - pose)[:3].max() < 1e-15


def test_misprint_2_3_pitch_of_the_wrong_screw():
    """J'J is p_c^2 / (8 pi^2) times 1: the printed p is the pitch of the gripper's screws, 355 times too small."""
    lead = 0.060
    square = c_drive.jacobian(lead).T @ c_drive.jacobian(lead)
    assert square == pytest.approx(lead**2 / (8.0 * np.pi**2) * np.eye(2))
    printed = P**2 / (8.0 * np.pi**2)
    assert square[0, 0] / printed == pytest.approx((2.0 * np.pi * 60.0 / 20.0) ** 2)


def test_misprint_2_10b_sign_of_b0():
    """With q_1z = z - b0 + p phi, q_2z = z + b0 - p phi most working postures have no solution."""
    poses = kinematics.forward(working_joints(20_000, seed=22), PROTOTYPE)
    heights = poses[:, 2:3] + np.array([-1.0, 1.0]) * (B0 - P * poses[:, 3:4])
    reach = poses[:, [1, 0]]
    solvable = (reach**2 + heights**2 <= (2.0 * R) ** 2).all(axis=1)
    assert solvable.mean() < 0.10
    assert np.isfinite(kinematics.inverse(poses, PROTOTYPE)).all()


def test_misprint_2_11_sine_printed_as_cosine():
    """cos = (1 - T^2)/(1 + T^2); 2T/(1 + T^2), printed as cos as well, is the sine."""
    theta = np.linspace(-3.0, 3.0, 13)
    tangent = np.tan(theta / 2.0)
    second = 2.0 * tangent / (1.0 + tangent**2)
    assert second == pytest.approx(np.sin(theta))
    assert np.abs(second - np.cos(theta)).max() > 1.0


def test_misprint_2_24_folded_limb():
    """lambda_1 = pi folds the limb to reach 0; lambda_1 = 0 gives the printed -0.825 rad."""
    alpha = limits.elevation_limits(PROTOTYPE).singular_min
    reach = {lam: R * np.cos(alpha) + R * np.cos(alpha + lam) for lam in (0.0, np.pi)}
    assert reach[np.pi] == pytest.approx(0.0, abs=1e-12)
    assert reach[0.0] == pytest.approx(PROTOTYPE.carriage_max)


def test_misprint_2_28a_wraps_theta_1_twice():
    """Bounds of theta_2 put on theta_1 would exclude part of the working branch."""
    joints = working_joints(10_000, seed=23)
    (_, _), (low2, high2) = limits.theta_bounds(PROTOTYPE)
    inside1 = (joints[:, 2] >= low2) & (joints[:, 2] <= high2)
    inside2 = (joints[:, 3] >= low2) & (joints[:, 3] <= high2)
    assert inside2.all()
    assert not inside1.all()


def test_explicit_forms_2_27_and_2_28d_are_right():
    joints = working_joints(1000, seed=24)
    d1, d2, t1, t2 = joints.T
    first = np.sin(t1) - np.sqrt(1.0 - (d2 - R * np.cos(t1)) ** 2 / R**2)
    second = np.cos(t2) - np.sqrt(1.0 - (d1 - R * np.sin(t2)) ** 2 / R**2)
    poses = kinematics.forward(joints, PROTOTYPE)
    assert poses[:, 2] == pytest.approx(0.5 * R * (first + second), abs=1e-14)
    printed_phi = R / (2.0 * P) * (first - second - 2.0 * B0 / R)
    assert poses[:, 3] == pytest.approx(printed_phi, abs=1e-11)


def test_misprint_5_4b_half_of_the_cycle():
    """With t = tau t_max the motor turns back half way, at full speed; with t = tau t_max / 2 it comes to rest at alpha."""
    program = motion.c_drive_motion("translation", rate=2.0)
    turn = 0.5 / program.rate
    angle, speed, _ = program.sample(turn)
    assert angle == pytest.approx([program.amplitude_L, program.amplitude_R])
    assert np.abs(speed).max() < 1e-9
    share, slope, _ = motion.polynomial_4567(turn * program.rate)
    assert share == pytest.approx(0.5)
    assert slope > 2.0
