"""``gapscope simulate pmc`` and ``gapscope compare pmc``."""

import json

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from gapscope.analysis.cli import app
from gapscope.analysis.errors import InputError
from gapscope.analysis.pmc import comparison
from gapscope.diagrams.pmc_loop import PMCLoopConfig
from gapscope.models.pmc import constants, kinematics
from gapscope.models.pmc.controllers import CONTROLLERS
from gapscope.models.pmc.prediction import MOTORS


def invoke(*arguments):
    return CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=False)


def test_simulate_writes_a_log_set_figure_and_replay(tmp_path):
    outcome = invoke("simulate", "pmc", "--controller", "ra", "--cycles", 0.1, "--out", tmp_path)
    assert outcome.exit_code == 0
    log_set = yaml.safe_load((tmp_path / "logset.yaml").read_text())
    assert log_set["format"] == 1
    assert log_set["system"]["kind"] == "pmc"
    assert log_set["controller"]["kind"] == "ra"
    table = np.genfromtxt(tmp_path / log_set["runs"][0]["file"], delimiter=",", names=True)
    assert list(table.dtype.names) == list(log_set["columns"])
    assert np.diff(table["t"]) == pytest.approx(log_set["sample_time_s"])
    # What the log says about the motors leads back to the pose that the cycle starts from.
    psi = np.array([table[f"psi_{m}"][-1] for m in MOTORS])
    joints = log_set["system"]["home"] + constants.joint_map(0.06) @ psi
    config = PMCLoopConfig()
    machine = config.machine()
    wanted = config.motion(machine).sample(table["t"][-1])[0]
    reached = kinematics.forward(joints, machine.geometry)
    assert reached[:3] == pytest.approx(wanted[:3], abs=1e-3)
    replay = (tmp_path / "replay.html").read_text()
    assert replay.startswith("<!DOCTYPE html>")
    assert 'src="http' not in replay
    assert (tmp_path / "run.png").stat().st_size > 10_000


def test_options_win_over_the_config(tmp_path):
    path = tmp_path / "loop.yaml"
    path.write_text("controller: ct\ncycle: smooth\nspeed: 2.0\n")
    options = ("--cycles", 0.02, "--no-replay", "--out", tmp_path / "out")
    assert (
        invoke("simulate", "pmc", "--config", path, "--cycle", "industry", *options).exit_code == 0
    )
    log_set = yaml.safe_load((tmp_path / "out" / "logset.yaml").read_text())
    assert log_set["name"] == "pmc-ct-industry"
    assert log_set["runs"][0]["speed"] == 2.0


def test_unusable_settings_are_one_clear_error(tmp_path):
    path = tmp_path / "loop.yaml"
    for text, message in (
        ("kontroller: ct\n", "kontroller"),
        ("placement: {z: -0.7}\n", "leaves the reach"),
        ("sample_time: -1.0\n", "sample_time is -1.0"),
    ):
        path.write_text(text)
        with pytest.raises(InputError, match=message):
            invoke("simulate", "pmc", "--config", path, "--out", tmp_path / "out")
    assert not list((tmp_path / "out").glob("*"))


@pytest.fixture(scope="module")
def compared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("compare")
    assert invoke("compare", "pmc", "--out", folder).exit_code == 0
    return folder


def test_comparison_has_every_row(compared):
    content = json.loads((compared / "comparison.json").read_text())
    expected = len(CONTROLLERS) * 2 * 2 * len(comparison.UNITS)
    assert len(content["rows"]) == expected
    assert {path.name for path in compared.iterdir()} == {
        "comparison.json",
        "comparison.md",
        "comparison.png",
        "prototype.png",
    }
    values = {
        (r["controller"], r["cycle"], r["counterweight"], r["metric"]): r["value"]
        for r in content["rows"]
    }
    # Chapter 6: resolved acceleration, with a model 5 % too heavy, beats the prototype's controller.
    for metric in ("position_rms_mm", "height_rms_mm", "rotation_rms_rad"):
        assert values["ra", "industry", True, metric] < 0.5 * values["ts", "industry", True, metric]
    # Section 5.2: nothing moves as asked without the counterweight.
    for name in CONTROLLERS:
        assert values[name, "industry", False, "height_rms_mm"] > 50.0


def test_counterweight_finding(compared):
    held = json.loads((compared / "comparison.json").read_text())["counterweight"]
    limit = PMCLoopConfig().machine().torque_limit
    assert held["isotropic"]["without"] > limit > held["isotropic"]["with"]
    assert held["held_share"]["with"][str(limit)] == 1.0
    assert held["held_share"]["without"][str(limit)] < 0.5
    assert held["needs_counterweight"] > 0.4


def test_flaws_of_the_prototype_hit_the_rotation_hardest(compared):
    """Section 5.2.2, as shares of the motion asked; a drive error turns the PM most at the isotropic height."""
    flaws = json.loads((compared / "comparison.json").read_text())["prototype"]
    assert [row["flaw"] for row in flaws["industry_cycle_shares"]] == [
        "joint_compliance",
        "link_compliance",
        "calibration",
        "unequal_loading",
    ]
    for row in flaws["industry_cycle_shares"]:
        assert row["rotation"] > 2.0 * max(row["across"], row["up"])
    peaks = flaws["peak_heights_m"]
    assert peaks["per_drive_error"] == pytest.approx(-0.3, abs=0.02)
    assert peaks["by_links"] == pytest.approx(-0.3, abs=0.02)
    assert peaks["by_loading"] == pytest.approx(-0.3, abs=0.02)
    assert peaks["by_joints"] is None
