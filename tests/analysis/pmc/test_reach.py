"""The exact surfaces of the PepperMill-Carrier against sampling of its joints."""

import numpy as np
import pytest

from gapscope.analysis.pmc import reach
from gapscope.models.pmc import kinematics, limits
from gapscope.models.pmc.geometry import Geometry

PROTOTYPE = Geometry()


def random_joints(n, seed):
    rng = np.random.default_rng(seed)
    safe = limits.elevation_limits(PROTOTYPE)
    d = rng.uniform(PROTOTYPE.carriage_min, PROTOTYPE.carriage_max, (n, 2))
    alpha = rng.uniform(safe.safe_min, safe.safe_max, (n, 2))
    return np.column_stack([d, alpha[:, 0], np.pi / 2 - alpha[:, 1]])


def within_limits(poses):
    """Whether poses meet the joint limits, by the inverse analysis."""
    joints = kinematics.inverse(poses, PROTOTYPE)
    (low1, high1), (low2, high2) = limits.theta_bounds(PROTOTYPE)
    tiny = 1e-9
    return (
        (joints[:, 2] >= low1 - tiny)
        & (joints[:, 2] <= high1 + tiny)
        & (joints[:, 3] >= low2 - tiny)
        & (joints[:, 3] <= high2 + tiny)
        & (np.abs(poses[:, 3] - PROTOTYPE.centre_angle) <= 2.0 * np.pi + tiny)
    )


@pytest.mark.parametrize("bounded", [False, True])
def test_no_pose_lies_beyond_the_surfaces(bounded):
    poses = kinematics.forward(random_joints(100_000, seed=31), PROTOTYPE)
    if bounded:
        poses = poses[np.abs(poses[:, 3] - PROTOTYPE.centre_angle) <= 2.0 * np.pi]
    low, high = reach.reachable_surfaces(poses[:, 0], poses[:, 1], PROTOTYPE, bounded=bounded)
    assert len(poses) > 10_000
    assert (poses[:, 2] >= low - 1e-12).all()
    assert (poses[:, 2] <= high + 1e-12).all()


def test_rotatability_is_what_the_inverse_analysis_allows():
    """At random positions some turn is allowed exactly where rotatability is positive, to both ends."""
    rng = np.random.default_rng(32)
    n = 20_000
    x, y = rng.uniform(PROTOTYPE.carriage_min, PROTOTYPE.carriage_max, (2, n))
    low, high = reach.reachable_surfaces(x, y, PROTOTYPE)
    z = rng.uniform(low, high)
    turn = reach.rotatability(x, y, z, PROTOTYPE)
    assert (turn > 0.0).all()
    assert (reach.rotatability(x, y, high + 1e-6, PROTOTYPE) == 0.0).all()
    wrists = reach.wrist_ranges(x, y, PROTOTYPE)
    reachable = np.pi * PROTOTYPE.turns * PROTOTYPE.pitch
    top = np.minimum.reduce([wrists.high1 - z, z - wrists.low2, np.full(n, reachable)])
    for share in (0.0, 0.5, 1.0):
        phi = PROTOTYPE.centre_angle + top / PROTOTYPE.pitch - share * turn
        assert within_limits(np.column_stack([x, y, z, phi])).all()
    for beyond in (1e-4, -turn - 1e-4):
        phi = PROTOTYPE.centre_angle + top / PROTOTYPE.pitch + beyond
        assert not within_limits(np.column_stack([x, y, z, phi])).any()


def test_turning_surfaces_allow_the_whole_turn():
    c = reach.cell_centres(PROTOTYPE, 20)
    x, y = (v.ravel() for v in np.meshgrid(c, c))
    for turn in (np.pi, 4.0 * np.pi):
        low, high = reach.turning_surfaces(x, y, turn, PROTOTYPE)
        for z, outwards in ((low, -1e-5), (high, 1e-5)):
            ends = [
                [
                    within_limits(np.column_stack([x, y, z + shift, np.full_like(x, phi)]))
                    for phi in PROTOTYPE.centre_angle + np.array([-0.5, 0.5]) * turn
                ]
                for shift in (0.0, outwards)
            ]
            assert np.all(ends[0])
            assert not np.all(ends[1], axis=0).any()


def test_volume_agrees_with_monte_carlo():
    """Hit-or-miss with n = 400 000, seed 33: within four standard deviations."""
    rng = np.random.default_rng(33)
    n = 400_000
    x, y = rng.uniform(PROTOTYPE.carriage_min, PROTOTYPE.carriage_max, (2, n))
    z = rng.uniform(-0.5, 0.15, n)
    box = 0.216**2 * 0.65
    share = np.mean(reach.rotatability(x, y, z, PROTOTYPE) > 0.0)
    c = reach.cell_centres(PROTOTYPE, 200)
    exact = reach.volume(reach.reachable_surfaces(c[:, None], c, PROTOTYPE), c, c)
    assert share * box == pytest.approx(exact, abs=4.0 * box * np.sqrt(share * (1 - share) / n))


def test_screw_range_lies_inside_what_the_drives_allow():
    """Fig. 2-7: everywhere in the xy square the parallelepiped of two turns is inside."""
    c = reach.cell_centres(PROTOTYPE, 50)
    least, most = reach.extreme_angles(c[:, None], c, PROTOTYPE)
    assert least.max() < PROTOTYPE.angle_min
    assert most.min() > PROTOTYPE.angle_max


def test_rectangle_ranges_hold_at_every_point_of_the_rectangle():
    x, y = (0.25, 0.40), (0.30, 0.33)
    whole = reach.rectangle_ranges(x, y, PROTOTYPE)
    points = reach.wrist_ranges(np.linspace(*x, 301)[:, None], np.linspace(*y, 301), PROTOTYPE)
    for name, worst in (("low1", np.max), ("low2", np.max), ("high1", np.min), ("high2", np.min)):
        assert getattr(whole, name) == pytest.approx(worst(getattr(points, name)), abs=1e-7)
