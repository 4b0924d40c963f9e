"""What the rig's README says: its states are those of the rig, and its commands, requests and settings are taken."""

import json
import re
import shlex
from pathlib import Path

import pytest
from typer import Context
from typer.main import get_command

from gapscope.analysis.cli import app
from gapscope.analysis.rig import machines
from gapscope.analysis.rig.states import REQUESTS, TRANSITIONS, Event, State

TEXT = Path(__file__).parents[3].joinpath("analysis", "rig", "README.md").read_text()
LINES = re.findall(r"^    ((?:gapscope|curl) .*)$", TEXT, re.MULTILINE)
EVERYWHERE = {Event.QUICK_STOP, Event.SHUT_DOWN}


def test_the_states_are_those_of_the_rig():
    rows = re.findall(r"^\| `(\w+)` \|(.*?)\|(.*?)\|$", TEXT, re.MULTILINE)
    assert [state for state, _, _ in rows] == list(State)
    for state, requests, by_itself in rows:
        after = TRANSITIONS[State(state)]
        allowed = {event for event in after if event in REQUESTS} - EVERYWHERE
        assert {*re.findall(r"`(\w+)`", requests)} == allowed, state
        ends = {after[e] for e in after if e not in REQUESTS and e is not Event.FAULT} - {state}
        assert {*re.findall(r"`(\w+)`", by_itself)} == ends, state
        assert after.keys() >= EVERYWHERE or state == State.OFF


@pytest.mark.parametrize("line", [line for line in LINES if line.startswith("gapscope")])
def test_commands_are_taken(line, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    root = get_command(app)
    name, command, rest = root.resolve_command(Context(root), shlex.split(line)[1:])
    given = command.make_context(name, rest).params
    if name == "rig":
        assert given["machine"] in (*machines.NAMES, "my.urdf")


def test_requests_record_a_run(bench):
    rig = bench("slider")
    program = rig.rig.machine.programs[0]
    words = [shlex.split(line) for line in LINES if line.startswith("curl") and "--json" in line]
    for _, url, _, body in words:
        assert url == "http://127.0.0.1:8642/request"
        request = json.loads(body.replace("PROGRAM", program))
        rig.ask(request["event"], **request.get("data", {}))
        rig.until_standing()
    (run,) = rig.rig.recorder.summary()["runs"]
    assert run["use"] == "validate"


def test_settings_of_a_robot_of_ones_own_are_taken(tmp_path):
    names, parent, text = ("shoulder", "elbow", "grip"), "base", ['<robot name="my">']
    for link in ("base", *(f"{name}_link" for name in names)):
        text.append(
            f'<link name="{link}"><inertial><origin xyz="0.1 0 0"/><mass value="1"/>'
            '<inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )
    for name in names:
        text.append(
            f'<joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{name}_link"/>'
            '<origin xyz="0.2 0 0"/><axis xyz="0 1 0"/>'
            '<limit lower="-1.5" upper="1.5" velocity="2" effort="50"/></joint>'
        )
        parent = f"{name}_link"
    model, settings = tmp_path / "my.urdf", tmp_path / "drive.yaml"
    model.write_text("".join([*text, "</robot>"]))
    (block,) = re.findall(r"^```yaml\n(.*?)^```", TEXT, re.MULTILINE | re.DOTALL)
    settings.write_text(block)
    made = machines.build(str(model), "mystery", 0, joints=["shoulder", "elbow"], settings=settings)
    assert made.layout.home == pytest.approx([0.5, -0.4], abs=1e-4)
    assert made.document()["controller"]["kp"] == [40.0, 20.0]
    assert made.document()["system"]["locked"] == {"grip": 0.1}
