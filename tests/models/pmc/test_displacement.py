"""Displacement analyses of the PepperMill-Carrier: inverse and forward agree in every mode."""

import time

import numpy as np
import pytest

from gapscope.models.pmc import kinematics
from gapscope.models.pmc.geometry import Geometry
from gapscope.models.pmc.kinematics import MODES, Mode

from .sampling import PROTOTYPE, distance, working_joints


def test_forward_undoes_inverse_on_the_working_branch():
    """1e5 poses: the asked 1e-9; eps * phi (80 rad) / slope of the law allows 1e-12."""
    poses = kinematics.forward(working_joints(100_000, seed=1), PROTOTYPE)
    again = kinematics.forward(kinematics.inverse(poses, PROTOTYPE), PROTOTYPE)
    assert np.abs(again - poses).max() < 1e-11


def test_inverse_undoes_forward_on_the_working_branch():
    joints = working_joints(100_000, seed=2)
    again = kinematics.inverse(kinematics.forward(joints, PROTOTYPE), PROTOTYPE)
    assert distance(again, joints) < 1e-11


@pytest.mark.parametrize("posture", MODES)
def test_every_posture_closes_the_loop(posture):
    """Each of the four inverse postures, put on the branch it lies on, returns the pose."""
    poses = kinematics.forward(working_joints(1000, seed=3), PROTOTYPE)
    joints = kinematics.inverse(poses, PROTOTYPE, posture)
    links = kinematics.link_elevations(poses, joints, PROTOTYPE)
    up = np.where(np.sin(links[:, 1::2]) > 0.0, 1, -1)
    clear = (np.abs(np.sin(links[:, 1::2])) > 1e-3).all(axis=1)
    again = np.array(
        [
            kinematics.forward(q, PROTOTYPE, Mode(int(f1), int(f2)))
            for q, (f1, f2) in zip(joints, up)
        ]
    )
    assert clear.sum() > 900
    assert np.abs(again - poses)[clear].max() < 1e-9


def test_four_postures_and_four_branches_are_distinct():
    joints = working_joints(1, seed=4)[0]
    pose = kinematics.forward(joints, PROTOTYPE)
    postures = np.array([kinematics.inverse(pose, PROTOTYPE, mode) for mode in MODES])
    branches = np.array([kinematics.forward(joints, PROTOTYPE, mode) for mode in MODES])
    for values in (postures, branches):
        assert len(np.unique(values.round(9), axis=0)) == 4


@pytest.mark.parametrize("branch", MODES)
def test_every_branch_keeps_the_link_lengths(branch):
    """Wrist and elbow are one distal length apart, in each of the four branches."""
    joints = working_joints(1000, seed=5)
    poses = kinematics.forward(joints, PROTOTYPE, branch)
    links = kinematics.link_elevations(poses, joints, PROTOTYPE)
    r, length = PROTOTYPE.proximal, PROTOTYPE.distal
    for limb, reach in ((0, poses[:, 1]), (1, poses[:, 0])):
        alpha, beta = links[:, 2 * limb], links[:, 2 * limb + 1]
        closed = r * np.cos(alpha) + length * np.cos(beta)
        assert np.abs(closed - reach).max() < 1e-12
    side = np.where(np.sin(links[:, 1::2]) > 0.0, 1, -1)
    assert (side == [branch.limb1, branch.limb2]).all()


def test_unequal_links_close_the_loop():
    geometry = Geometry(proximal=0.28, distal=0.33)
    joints = working_joints(1000, seed=6, geometry=geometry)
    poses = kinematics.forward(joints, geometry)
    assert distance(kinematics.inverse(poses, geometry), joints) < 1e-11


def test_out_of_reach_is_nan_for_that_row_only():
    poses = np.array([kinematics.isotropic_pose(PROTOTYPE), [0.3, 0.3, -0.7, -76.0]])
    joints = kinematics.inverse(poses, PROTOTYPE)
    assert np.isfinite(joints[0]).all()
    assert np.isnan(joints[1]).all()


def test_wrong_shape_and_mode_are_refused():
    with pytest.raises(ValueError, match="last axis of 4"):
        kinematics.inverse(np.zeros((5, 3)), PROTOTYPE)
    with pytest.raises(ValueError, match=r"expected \+1"):
        Mode(0, 1)


def test_a_million_analyses_a_second():
    """Asked: 1e6 a second. Measured 5e6 or more on one core, time of the thread."""
    joints = working_joints(200_000, seed=7)
    poses = kinematics.forward(joints, PROTOTYPE)
    for analysis, values in ((kinematics.inverse, poses), (kinematics.forward, joints)):
        analysis(values, PROTOTYPE)
        times = []
        for _ in range(5):
            start = time.thread_time()
            analysis(values, PROTOTYPE)
            times.append(time.thread_time() - start)
        assert len(values) / min(times) > 1e6
