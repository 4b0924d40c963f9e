"""A robot by its model file, in Drake's Simulator with faults that the file lacks: are they named?"""

import pytest
from matplotlib import image

from gapscope.analysis import two_joint_robot
from gapscope.analysis.examples import your_own_robot
from gapscope.analysis.gap.diagnosis import diagnose

pytestmark = pytest.mark.slow


def test_the_example_names_the_hidden_friction_of_the_shoulder(tmp_path):
    result = your_own_robot.main(tmp_path).to_json()
    assert result["verdict"] == "explained"
    (effect,) = result["effects"]
    assert (effect["id"], effect["where"]) == ("friction.coulomb", {"joints": ["shoulder"]})
    level = effect["parameters"]["level_shoulder"]["value"]
    assert level == pytest.approx(your_own_robot.HIDDEN[0], rel=0.02)
    assert result["shrinkage"]["percent"] > 80.0
    assert (tmp_path / "diagnosis.json").is_file()
    assert image.imread(tmp_path / "your_own_robot.png")[..., :3].std() > 0.02


def test_an_arm_that_is_its_model_has_no_gap(tmp_path):
    assert diagnose(two_joint_robot.record(tmp_path)).to_json()["verdict"] == "no_gap"


def test_a_mass_at_the_tip_is_a_payload(tmp_path):
    result = diagnose(two_joint_robot.record(tmp_path, payload=0.2)).to_json()
    assert result["verdict"] == "explained"
    assert [e["id"] for e in result["effects"]] == ["inertia.payload"]
    assert result["effects"][0]["where"] == {"bodies": ["forearm"]}


def test_a_hum_on_the_shoulder_is_nothing_that_is_known(tmp_path):
    result = diagnose(two_joint_robot.record(tmp_path, hum=0.4)).to_json()
    assert result["verdict"] == "unexplained"
    assert result["effects"] == []
