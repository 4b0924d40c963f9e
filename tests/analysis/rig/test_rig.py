"""The rig as its user meets it: home, jog, switches, stops, trajectories, log sets."""

import numpy as np
import pytest
import yaml

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.rig.setpoints import Ramp, rest_to_rest
from gapscope.analysis.rig.states import Refused, State


@pytest.mark.parametrize("kind", ["c-drive", "slider"])
def test_homing_finds_where_the_switch_is(bench, kind):
    """Readings after homing are true positions, to what the machine covers while the switch is asked."""
    b = bench(kind)
    axis = b.rig.machine.layout.axes[0]
    assert abs(b.axes()[0] - b.rig.machine.true_axes()[0]) > 0.01  # unknown before
    b.home()
    assert b.rig.homed
    per_sample = 0.02 * axis.speed * b.rig.machine.layout.dt
    counts = b.rig.machine.layout.lsb * np.abs(b.rig.machine.layout.axis_map[0]).sum()
    assert abs(b.axes()[0] - b.rig.machine.true_axes()[0]) < 3.0 * per_sample + counts
    wanted = b.rig.machine.layout.axis(b.rig.machine.layout.home)
    assert abs(b.axes()[0] - wanted[0]) < 5e-4  # went to its home position


def test_control_needs_a_homed_machine_and_reset_forgets(bench):
    b = bench()
    with pytest.raises(Refused, match="needs a homed machine"):
        b.ask("control")
    b.home()
    b.ask("control")
    b.ask("quick_stop")
    b.ask("reset")
    b.tick(1)
    assert b.rig.state is State.OPERATE
    with pytest.raises(Refused, match="needs a homed machine"):
        b.ask("control")


def test_jog_follows_the_asked_speed_and_comes_to_rest(bench):
    b = bench()
    b.home()
    b.ask("jog")
    before = b.axes()[1]
    b.ask("start", axis="turn", speed=0.5)
    b.tick(2000)
    axis = b.rig.machine.layout.axes[1]
    ramp = 0.5 * axis.speed / axis.acceleration
    expected = 0.5 * axis.speed * (2.0 - 0.5 * ramp)
    # Behind the setpoint by what the viscous friction asks of a PD: some hundredths of a radian.
    assert b.axes()[1] - before == pytest.approx(expected, abs=0.05)
    b.ask("halt")
    b.until_standing()
    assert b.rig.state is State.JOG
    stood = b.axes()
    b.tick(100)
    np.testing.assert_array_equal(b.axes(), stood)


def test_a_switch_holds_the_jog_and_leaves_the_way_back_free(bench):
    b = bench("slider")
    b.home()
    b.ask("jog")
    b.ask("start", axis="axis", speed=1.0)
    b.until_standing()
    axis = b.rig.machine.layout.axes[0]
    assert b.rig.state is State.JOG
    overrun = b.rig.machine.true_axes()[0] - axis.high
    # Braking way from full speed at the jog's deceleration, and the lag of the loop.
    assert 0.0 < overrun < axis.speed**2 / (2.0 * axis.acceleration) + 0.01
    with pytest.raises(InputError, match="the way back"):
        b.ask("start", axis="axis", speed=0.2)
    b.ask("start", axis="axis", speed=-0.5)
    b.tick(1500)
    assert b.rig.machine.true_axes()[0] < axis.high
    assert not b.rig.status()["switches"]


def test_a_switch_stops_a_trajectory(bench):
    b = bench("slider")
    b.home()
    b.ask("control")
    b.ask("load", name="long", rate_Hz=0.5, cycles=1)
    reading = b.rig.machine.read()
    b.rig.machine._q = b.rig.machine._q + 0.1  # the encoder lost its place
    b.rig.machine.preset(reading)
    b.ask("start")
    b.until_standing()
    assert b.rig.state is State.STOP
    assert "limit switch +axis" in b.rig.message
    assert not b.rig.recorder.summary()["runs"]


@pytest.mark.parametrize("kind", ["c-drive", "slider", "pmc", "5r", "mm3a", "furuta", "arm"])
def test_quick_stop_brings_every_machine_to_rest_fast_and_keeps_no_run(bench, kind):
    b = bench(kind)
    b.home()
    b.ask("control")
    layout = b.rig.machine.layout
    rate = 0.5 * layout.rate
    b.ask("load", name=b.rig.machine.programs[0], rate_Hz=rate, cycles=2)
    b.ask("start")
    while not b.rig._rows:
        b.tick(1)
    b.tick(round(0.2 / (rate * layout.dt)))  # somewhere on the way out
    b.ask("quick_stop")
    assert b.rig.state is State.STOP
    speed = np.abs(b.rig._ramp.speed)
    assert speed.max() > 0.0
    samples = b.rig.samples
    b.until_standing()
    braking = max(v / (4.0 * axis.acceleration) for v, axis in zip(speed, layout.axes))
    assert b.rig.samples - samples <= braking / layout.dt + 3
    stood = b.rig.machine.true_axes()
    b.tick(50)
    np.testing.assert_array_equal(b.rig.machine.true_axes(), stood)
    assert not b.rig.recorder.summary()["runs"]
    assert not list(b.rig.recorder.folder.iterdir())


def test_a_lost_following_error_is_a_fault(bench):
    b = bench("slider")
    b.home()
    b.ask("control")
    b.ask("load", name="long", rate_Hz=3.0, cycles=1)  # more than 350 N can follow
    b.ask("start")
    b.until_standing()
    assert b.rig.state is State.STOP
    assert "following error" in b.rig.message


def test_requests_with_bad_data_change_nothing(bench):
    b = bench()
    b.home()
    b.ask("control")
    for data, message in (
        ({"name": "spiral"}, "unknown motion"),
        ({"name": "helical", "rate_Hz": 0.0}, "rate is 0.0"),
        ({"name": "helical", "cycles": 1.5}, "cycles is 1.5"),
        ({"csv": "t,left\n0,1\n"}, "columns t, left, right"),
        ({"csv": "t,left,right\n" + "".join(f"{i * 0.002},0,0\n" for i in range(20))}, "0.001 s"),
        (
            {"csv": "t,left,right\n" + "".join(f"{i * 0.001},{i},{-i}\n" for i in range(50))},
            "switches",
        ),
        ({"csv": ""}, "header"),
        ({"speed": 3}, "unknown key 'speed'"),
    ):
        with pytest.raises(InputError, match=message):
            b.ask("load", **data)
        assert b.rig.state is State.CONTROL
    b.ask("close")
    b.ask("configure")
    before = b.rig.machine.settings()
    for data in (
        {"controller": {"kp": 3}},
        {"nominal": {"delta_N_m": -1.0}},
        {"controller": {"kind": "magic"}},
        {"gains": {}},
        {"controller": 3},
    ):
        with pytest.raises(InputError):
            b.ask("set", **data)
        assert b.rig.machine.settings() == before


def test_a_table_is_followed_and_logged(bench):
    b = bench()
    b.home()
    b.ask("control")
    t = np.arange(500) * 1e-3
    turn = 0.5 * (1.0 - np.cos(2.0 * np.pi * t / 0.5))
    b.ask(
        "load",
        csv="t,left,right\n" + "".join(f"{a:.3f},{x:.9f},{x:.9f}\n" for a, x in zip(t, turn)),
    )
    b.ask("start")
    b.until_standing()
    log = load_logset(b.rig.recorder.summary()["folder"])
    np.testing.assert_allclose(log.runs[0].columns["psi_L_ref"], turn, atol=1e-9)
    assert np.abs(log.runs[0].columns["psi_L"] - turn).max() < 0.1


RUNS = (
    ("translation", 2.0, "fit"),
    ("rotation", 2.0, "fit"),
    ("helical", 2.0, "fit"),
    ("helical", 1.5, "validate"),
)


def test_a_sound_machine_has_no_gap(bench):
    """What the rig logs is what the nominal model under the stated controller does."""
    b = bench(fault="none")
    b.home()
    b.ask("control")
    b.record("helical", use="fit")
    b.record("helical", rate=1.5, use="validate")
    found = diagnose(b.rig.recorder.summary()["folder"])
    assert found.verdict.verdict == "no_gap"
    assert all(check.disagreement < 1e-6 for check in found.replays)


@pytest.mark.slow
def test_a_whole_session_measure_diagnose_mend_measure_again(bench):
    """Dry friction that nobody told of is found, the nominal model is mended with it, and the gap is gone."""
    b = bench(fault="friction", seed=4)
    b.home()
    b.ask("control")
    for motion, rate, use in RUNS:
        b.record(motion, rate=rate, use=use)
    first = b.rig.recorder.summary()["folder"]
    found = diagnose(first).to_json()
    assert found["verdict"] == "explained"
    assert [effect["id"] for effect in found["effects"]] == ["friction.coulomb"]
    parameters = found["effects"][0]["parameters"]
    levels = [p["value"] for name, p in parameters.items() if name.startswith("level")]
    truth = float(b.rig.machine.answer.split(" of ")[1].split()[0])
    assert np.mean(levels) == pytest.approx(truth, rel=0.05)
    b.ask("close")
    b.ask("configure")
    b.ask("set", nominal={"delta_N_m": float(np.mean(levels)), "eta_N_m": float(np.mean(levels))})
    b.ask("close")
    b.ask("control")
    for motion, rate, use in RUNS:
        b.record(motion, rate=rate, use=use)
    second = b.rig.recorder.summary()["folder"]
    assert second != first  # other settings, another log set
    text = yaml.safe_load((b.rig.recorder.folder / "measurement2" / "logset.yaml").read_text())
    assert "answer" not in text
    assert text["system"]["nominal"]["delta_N_m"] == np.mean(levels)
    assert diagnose(second).verdict.verdict == "no_gap"


def test_a_carrier_runs_its_cycle_and_logs_it(bench):
    b = bench("pmc")
    b.home()
    b.ask("control")
    b.record("industry", rate=1.0, cycles=1)
    log = load_logset(b.rig.recorder.summary()["folder"])
    assert log.kind == "pmc"
    error = log.runs[0].columns["psi_L1"] - log.runs[0].columns["psi_L1_ref"]
    assert 0.0 < np.abs(error).max() < 0.5


def test_moves_from_rest_to_rest_keep_their_bounds():
    speed, acceleration = np.array([0.2, 3.0]), np.array([2.0, 20.0])
    start, end = np.array([0.0, 1.0]), np.array([0.1, -4.0])
    way, _ = rest_to_rest(start, end, speed, acceleration, 1e-3)
    path = np.vstack([start, way])
    rate = np.diff(path, axis=0) / 1e-3
    second = np.diff(rate, axis=0) / 1e-3
    used = [np.max(np.abs(rate) / speed), np.max(np.abs(second) / acceleration)]
    # One bound is used up, to the rounding of the time to whole samples; the other is kept.
    assert max(used) == pytest.approx(1.0, abs=2e-3)
    assert max(used) <= 1.0 + 1e-9
    np.testing.assert_array_equal(way[-1], end)


def test_a_ramp_reaches_its_speed_and_rest_exactly():
    ramp = Ramp(np.zeros(1), np.zeros(1), np.array([2.0]), 1e-3)
    ramp.wanted[:] = 0.1005
    for _ in range(100):
        ramp.advance()
    assert ramp.speed[0] == 0.1005
    ramp.wanted[:] = 0.0
    for _ in range(51):
        ramp.advance()
    assert ramp.at_rest
