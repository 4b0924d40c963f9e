"""Workspaces of the parallel machines beside what the sources print."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from gapscope.analysis.cli import app
from gapscope.analysis.identification.polygon import inside
from gapscope.analysis.parallel import cmm, planar, tables
from gapscope.models.parallel import five_bar
from gapscope.models.parallel.five_bar import FiveBar


def test_every_printed_forward_solution_of_the_3prs_is_reproduced():
    """Table 4, columns FKP: printed to 1 um and 1'' from sliders printed to 1 um (1'' is 0.4 um at a joint)."""
    for row in tables.measured():
        assert row["z_um"]["ours"] == pytest.approx(row["z_um"]["printed_fkp"], abs=1.5)
        for angle in ("psi_arcsec", "theta_arcsec"):
            assert row[angle]["ours"] == pytest.approx(row[angle]["printed_fkp"], abs=2.0)


def test_printed_errors_of_table_5_follow_from_the_rows():
    """|CMM - FKP| of z: 87, 8, 5, 74 um; a check of what was typed in."""
    off = [abs(row.z[0] - row.z[2]) for row in cmm.ROWS]
    assert off == [87, 8, 5, 74]


def test_flexures_alone_explain_the_stiffness_of_the_finite_elements():
    """Table 2: the joints' printed stiffness gives the actuator force within 5 %, without a fit."""
    for row in tables.stiffness():
        assert row["ours_N"] == pytest.approx(row["printed_N"], rel=0.05)


def test_tilt_limits_end_at_a_stop():
    """One step further a slider leaves its travel, a leg opens, or the table is near a singularity."""
    found = tables.compliant()
    assert found.largest[2].min() > np.deg2rad(0.2)
    assert found.largest[0].max() < found.largest[2].max()


def test_the_mast_reaches_its_tilt_in_use():
    assert tables.mast().findings["reaches_tilt_in_use_at_home"]


def test_joint_space_of_the_five_bar_holds_no_singularity():
    result = planar.linkage("5r")
    ring = result.joint_space
    box = np.random.default_rng(1).uniform(ring.min(axis=0), ring.max(axis=0), (2000, 2))
    q = box[inside(box, ring) > 0.0]
    at = five_bar.forward(q, FiveBar())
    assert np.abs(np.sin(at.angle3 - at.angle2)).min() > np.sin(np.deg2rad(15.0))
    assert result.dexterity.min() > 0.0
    areas = result.findings["area_by_working_mode_m2"]
    assert max(areas, key=areas.get) == "+1, -1"  # elbows outwards


def test_printed_rectangle_of_the_2prr_needs_a_point_below_the_joint():
    result = planar.slider_pair()
    found = result.findings["printed_rectangle"]
    assert result.findings["workspace"]["y_m"][0] > -0.654
    assert found["share_inside_as_printed"] < found["largest_share_inside"]


@pytest.mark.parametrize(
    ("name", "figures"), [("3prs", ("tilts", "measured")), ("2prr", ("workspace",))]
)
def test_command_writes_findings_and_figures(name, figures, tmp_path):
    done = CliRunner().invoke(app, ["workspace", name, "--out", str(tmp_path)])
    assert done.exit_code == 0, done.output
    assert json.loads((tmp_path / "workspace.json").read_text())
    for figure in figures:
        assert (tmp_path / f"{figure}.png").stat().st_size > 1000
