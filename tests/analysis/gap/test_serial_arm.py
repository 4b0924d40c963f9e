"""Logs of an arm of position servos: what sags is named at the joints that sag, dry friction where it is.

The logs come from a generator of its own: explicit steps of two milliseconds, weights of links with masses and
lengths, a friction that is compared with the drive.
"""

from itertools import pairwise

import numpy as np
import pytest
import yaml

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.machines.repeated import repeats

DT, FINE, PERIOD = 0.02, 10, 8.0
JOINTS = ("base", "pitch", "elbow")
LAG, STIFFNESS, ENCODER = 0.07, 8.0, 2.0 * np.pi / 4096
MOTIONS = ((0.3, 0.0), (0.6, 1.0), (0.9, 2.0), (0.5, 3.0))  # size [rad] and phase of each run
FRICTION = np.array([[0.01], [0.02], [0.03]])  # of the joints [rad]
REST = 2.0  # seconds of every period that the references stand still


def reference(size, phase):
    """Motions (samples, 3) that repeat after PERIOD, with a rest at the end of each."""
    t = np.arange(0.0, 2.0 * PERIOD + DT / 2, DT)
    moving = np.minimum(t % PERIOD, PERIOD - REST) / (PERIOD - REST)
    return np.column_stack(
        [size * np.sin(2.0 * np.pi * (k * moving) + phase * k) for k in (1, 2, 3)]
    )


def weight(q):
    """Torques of the links' weight over the stiffness; the base turns about the vertical."""
    forearm = 0.2 * 9.81 * 0.12 * np.cos(0.4 + q[1] + q[2])
    upper = 0.4 * 9.81 * 0.1 * np.cos(q[1] - 0.3)
    return -np.array([0.0 * upper, upper + forearm, forearm]) / STIFFNESS


def simulate(asked, load, friction):
    """Paths (samples, 3, runs) of all runs at once."""
    q = asked[0]
    path = [q]
    for a, b in pairwise(asked):
        for i in range(FINE):
            drive = a + i / FINE * (b - a) - q + load(q)
            moves = np.abs(drive) > friction
            q = q + DT / FINE / LAG * moves * (drive - np.sign(drive) * friction)
        path.append(q)
    return np.array(path)


def write(folder, *, load=lambda q: 0.0 * q, friction=0.0, torque=True, change=()):
    folder.mkdir()
    runs = []
    motions = np.stack([reference(size, phase) for size, phase in MOTIONS], axis=2)
    paths = simulate(motions, load, friction)
    for i, (asked, q) in enumerate(zip(motions.transpose(2, 0, 1), paths.transpose(2, 0, 1))):
        seen = ENCODER * np.round(q / ENCODER)
        t = DT * np.arange(len(q))
        torques = [STIFFNESS * np.abs(asked - q)] if torque else []
        table = np.column_stack([t, asked, seen, *torques])
        kinds = ("_ref", "", "_abs_torque") if torque else ("_ref", "")
        names = ["t", *(f"{j}{kind}" for kind in kinds for j in JOINTS)]
        np.savetxt(folder / f"run{i}.csv", table, delimiter=",", header=",".join(names), comments="",
                   fmt="%.8f")  # fmt: skip
        runs.append({"file": f"run{i}.csv", "use": "validate" if i == 3 else "fit"})
    columns = {"t": "s", "JOINT_ref": "rad", "JOINT": "rad"}
    document = {
        "format": 1, "name": "arm", "sample_time_s": DT, "runs": runs,
        "system": {"kind": "serial_arm", "joints": list(JOINTS), "parallel_axes": ["pitch", "elbow"]},
        "controller": {"kind": "servo_position"},
        "columns": columns | ({"JOINT_abs_torque": "N m"} if torque else {}),
    }  # fmt: skip
    for keys, value in change:
        *path, last = keys.split(".")
        place = document
        for key in path:
            place = place[key]
        place[last] = value
    (folder / "logset.yaml").write_text(yaml.safe_dump(document))
    return folder


def named(result):
    return {e["id"]: set(e["where"]["joints"]) for e in result["effects"]}


def test_nothing_is_said_of_servos_that_follow(tmp_path):
    assert diagnose(write(tmp_path / "set")).verdict.verdict == "no_gap"


def test_weight_is_named_at_the_joints_that_carry_it(tmp_path):
    found = diagnose(write(tmp_path / "set", load=weight)).to_json()
    assert (found["verdict"], named(found)) == ("explained", {"load.bias": {"pitch", "elbow"}})
    assert found["effects"][0]["form"] == "gravity of the links"
    assert found["shrinkage"]["ci95"][0] > 90.0


def test_dry_friction_is_named_where_the_torque_shows_that_the_servo_feels_it(tmp_path):
    found = diagnose(write(tmp_path / "set", friction=FRICTION)).to_json()
    assert (found["verdict"], named(found)) == ("explained", {"friction.coulomb": set(JOINTS)})
    for joint, level in zip(JOINTS, FRICTION[:, 0]):
        value = found["effects"][0]["parameters"][f"level_{joint}"]["value"]
        assert value == pytest.approx(level, abs=ENCODER)


def test_without_torque_a_constant_load_may_be_a_false_zero(tmp_path):
    found = diagnose(
        write(tmp_path / "set", load=lambda q: np.array([[0.0], [0.03], [0.0]]), torque=False)
    ).to_json()
    assert found["verdict"] == "ambiguous"
    assert named(found) == {"load.bias": {"pitch"}, "sensor.offset": {"pitch"}}


@pytest.mark.parametrize("torque", [False, True])
def test_clearance_is_tried_where_no_torque_follows_the_error(tmp_path, torque):
    folder = write(tmp_path / "set", friction=FRICTION, torque=torque)
    machine, runs = read_machine(load_logset(folder))
    assert ("transmission.backlash" in {form.effect for form in machine.forms(runs)}) != torque


def test_stretches_repeat_only_while_something_moves():
    asked = reference(0.5, 0.0)[::5]
    period = round(PERIOD / DT / 5)
    ((stretch, lag),) = repeats(asked, 1e-3)
    assert (stretch, lag) == (slice(period, len(asked)), period)
    assert repeats(np.zeros((200, 3)), 1e-3) == []


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ([("system.joints", ["pitch", "pitch", "base"])], "each once"),
        ([("system.parallel_axes", ["wrist"])], "parallel_axes: 'wrist'"),
        ([("system.payload", 1.0)], "unknown key 'payload'"),
        ([("system.nominal", {"delay_s": -1.0})], "a positive number"),
        ([("controller.kind", "joint_pd")], "expected servo_position"),
        ([("columns.JOINT", "deg")], "the unit is 'deg'"),
        ([("columns.JOINT_abs_torque", "A")], "the unit is 'A'"),
        ([("columns.JOINT_abs_torque", "N mm from current")], "the unit is 'N mm from current'"),
    ],
)
def test_a_bad_description_is_one_clear_error(tmp_path, change, message):
    folder = write(tmp_path / "set", change=change)
    with pytest.raises(InputError) as error:
        read_machine(load_logset(folder))
    assert message in str(error.value)


@pytest.mark.slow
def test_measured_arm_sags_at_the_loaded_joints(shared_data):
    """Gravity loads pitch, elbow and wrist_pitch; rotation is vertical, wrist_roll and jaw carry little."""
    found = diagnose(shared_data / "so101_arm").to_json()
    leading = found["leading"]
    assert found["verdict"] == "unexplained"  # the fit runs hold end stops, which no effect makes
    assert set(leading["where"]["load.bias"]["joints"]) == {"pitch", "elbow", "wrist_pitch"}
    assert set(leading["ids"]) & {"friction.coulomb", "friction.load_dependent"}
    assert leading["ci95"][0] > 60.0
