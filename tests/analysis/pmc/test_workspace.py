"""The workspace study of the PepperMill-Carrier and the command that writes it."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from gapscope.analysis.cli import app
from gapscope.analysis.pmc import cycle_fit, inscribed, maps, optimum, reach, transmission
from gapscope.models.pmc import kinematics
from gapscope.models.pmc.cycle import IndustryCycle
from gapscope.models.pmc.geometry import Geometry

PROTOTYPE = Geometry()


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    folder = tmp_path_factory.mktemp("pmc")
    outcome = CliRunner().invoke(
        app, ["workspace", "pmc", "--out", str(folder), "--grid", "3"], catch_exceptions=False
    )
    assert outcome.exit_code == 0
    return folder


@pytest.fixture(scope="module")
def found(written):
    return json.loads((written / "workspace.json").read_text())


def test_everything_is_written(written):
    names = {path.name for path in written.iterdir()} - {".rows"}
    assert {"workspace.json", "workspace.html", "reachable_workspace.png"} <= names
    assert all((written / name).stat().st_size > 5000 for name in names)
    assert len(list((written / ".rows").iterdir())) == 6


def test_optimised_surfaces_are_confirmed(found):
    """KKT, dense grid and the exact linear programme agree on all 18 optima."""
    check = found["surfaces"]["check"]
    assert check["optima"] == 18
    assert check["confirmed"]
    assert check["exact_error_max_m"] < 1e-9


def test_screws_cost_volume(found):
    values = [
        found["volumes_m3"][kind]["value"]
        for kind in ("unbounded", "reachable", "half_turn", "full_range")
    ]
    assert values == sorted(values, reverse=True)
    assert values[0] - values[1] > 1e-4


def test_the_industry_cycle_fits_only_on_a_diagonal(found):
    """Section 3.2: 300 mm fit on the diagonal of the square with the printed 4 mm margin of 216 mm."""
    cycle = found["industry_cycle"]
    assert cycle["fits"]
    margin = (0.216 - 0.300 / np.sqrt(2.0)) / 2.0 / 0.216
    for fit in cycle["placements"]:
        direction = fit["placement"]["direction"] % np.pi
        assert min(abs(direction - np.pi / 4), abs(direction - 3 * np.pi / 4)) < 1e-4
        assert fit["slack_shares"]["carriage"] == pytest.approx(margin, abs=1e-6)


def test_turning_torque_peaks_in_the_middle_of_the_height(found):
    """Section 5.2.2: the central vertical region needs the largest torques; at the isotropic height."""
    peaks = found["conditioning"]["central_axis"]["peak_heights_m"]
    assert peaks == pytest.approx([-0.3], abs=0.015)


def test_maps_are_written_over_the_whole_workspace(written):
    """The share of a regular grid that lies inside is the volume; the most even point is the isotropic posture."""
    table = np.genfromtxt(written / "maps.csv", delimiter=",", names=True)
    found = maps.maps(PROTOTYPE)
    cell = (0.216 / 40) ** 2 * (found.z[1] - found.z[0])
    at_edge = sum(np.isclose(table[f"{axis}_m"], end) for axis in "xy" for end in (0.191, 0.407))
    volume = (0.5**at_edge).sum() * cell
    # Points at the surfaces count whole: one layer of 25 is uncertain.
    assert volume == pytest.approx(0.02086, rel=0.03)
    assert table["rotation_rad"].max() == pytest.approx(4.0 * np.pi, rel=1e-5)  # six digits
    best = table[np.nanargmin(table["condition_number"])]
    pose = [best["x_m"], best["y_m"], best["z_m"]]
    assert pose == pytest.approx(kinematics.isotropic_pose(PROTOTYPE)[:3], abs=0.03)


def test_maps_are_those_of_each_posture():
    found = maps.maps(PROTOTYPE, n=5, heights=np.array([-0.25]))
    pose = np.array([found.x[1], found.x[3], -0.25, PROTOTYPE.centre_angle])
    joints = kinematics.inverse(pose, PROTOTYPE)
    assert found.condition[0, 1, 3] == kinematics.condition_number(pose, joints, PROTOTYPE)
    assert found.error[0, 1, 3] == transmission.turning_error(pose, joints, PROTOTYPE)
    assert found.rotation[0, 1, 3] == reach.rotatability(*pose[:3], PROTOTYPE)


def test_section_over_the_diagonal_is_that_of_the_maps():
    section = maps.diagonal(PROTOTYPE, n=5, heights=7)
    found, along = maps.maps(PROTOTYPE, n=5, heights=section.z), np.arange(5)
    for name in ("rotation", "condition", "torque", "error"):
        whole = getattr(found, name)[:, along, along]
        np.testing.assert_allclose(getattr(section, name), whole, rtol=1e-12)
    assert np.isfinite(section.condition).any()


def test_kkt_residual_sees_a_point_that_is_no_optimum():
    problem = optimum._Problem(0.3, 0.3, -1.0, PROTOTYPE)
    top = np.array([high if i == 0 else low for i, (low, high) in enumerate(problem.bounds)])
    assert optimum._kkt_residual(problem, top) < 1e-9
    assert optimum._kkt_residual(problem, top + np.array([-0.1, 0.1])) > 0.1
    bottom = np.array([problem.bounds[0][0], problem.bounds[1][1]])
    assert optimum._kkt_residual(problem, bottom) > 0.1


def test_optimum_outside_the_stroke_is_refused():
    with pytest.raises(ValueError, match=r"d2 is 0\.5 m; expected it in the stroke"):
        optimum.extreme_height(0.3, 0.5, "low", PROTOTYPE)


def test_nothing_feasible_is_none():
    """With a lead of 0.2 mm the screws cannot bridge unequal reaches under narrow drive angles."""
    narrow = Geometry(lead=0.0002, distal_margin=1.2, fold_margin=1.2, carriage_min=0.1)
    assert np.isnan(reach.reachable_surfaces(0.1, 0.407, narrow)).all()
    assert optimum.extreme_height(0.1, 0.407, "high", narrow) is None


@pytest.mark.parametrize("turn", [None, np.pi])
def test_largest_bodies_fit_and_cannot_grow_upwards(turn):
    def inside(x, y, z):
        free = reach.rotatability(x, y, z, PROTOTYPE)
        return free > 0.0 if turn is None else free >= turn * (1.0 - 1e-9)

    rng = np.random.default_rng(41)
    u = rng.uniform(0.0, 1.0, (3, 50_000))
    box = inscribed.largest_cuboid(PROTOTYPE, turn)
    x, y, z = (low + s * (high - low) for s, (low, high) in zip(u, (box.x, box.y, box.z)))
    assert inside(x, y, z).all()
    assert not inside(x, y, np.full_like(x, box.z[1] + 1e-3)).all()
    can = inscribed.largest_cylinder(PROTOTYPE, turn)
    radius, around = can.radius * np.sqrt(u[0]), 2.0 * np.pi * u[1]
    x, y = can.centre[0] + radius * np.cos(around), can.centre[1] + radius * np.sin(around)
    assert inside(x, y, can.z[0] + u[2] * (can.z[1] - can.z[0])).mean() > 0.9999


def test_slack_of_a_path_out_of_reach_is_negative():
    cycle = cycle_fit.Placement(x=0.2, y=0.3, z=-0.3, phi=PROTOTYPE.centre_angle, direction=0.0)
    assert cycle_fit.cycle_slacks(IndustryCycle(placement=cycle), PROTOTYPE).least < 0.0


def test_motor_torques_balance_virtual_power():
    """Force times speed of the PM and of the four motors cancel for any motion (statics)."""
    from gapscope.models.c_drive import motor_angles

    rng = np.random.default_rng(42)
    poses = np.array([[0.25, 0.35, -0.2, PROTOTYPE.centre_angle + 2.0]] * 50)
    joints = kinematics.inverse(poses, PROTOTYPE)
    rates = rng.normal(size=(50, 4))
    wrench = rng.normal(size=(50, 4))
    torques = transmission.motor_torques(wrench, poses, joints, PROTOTYPE, 0.06)
    motors = np.concatenate([motor_angles(rates[:, i::2], 0.06) for i in (0, 1)], axis=1)
    speeds = np.einsum("nij,nj->ni", kinematics.jacobian(poses, joints, PROTOTYPE), rates)
    power = (torques * motors).sum(axis=1) + (wrench * speeds).sum(axis=1)
    assert np.abs(power).max() < 1e-11
