"""Piezo logs: hysteresis, lag and drift are told apart, and nothing is said of what is unknown.

The logs come from a generator of its own: plays instead of stops, more of them than the instrument has,
and a lag of many short steps.
"""

import numpy as np
import pytest
import yaml

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.machines.piezo_stack import cycle

DT, CYCLES, PERIOD = 0.005, 8, 1.0
NOISE = 0.05  # [um]
FINE = 50  # steps of the generator a sample


def play(drive, radius):
    out, state = np.empty_like(drive), 0.0
    for k, value in enumerate(drive):
        state = max(value - radius, min(value + radius, state))
        out[k] = state
    return out


def lagged(drive, lag):
    out, state = np.empty_like(drive), 0.0
    for k, value in enumerate(drive):
        state += DT / FINE / lag * (value - state)
        out[k] = state
    return out


def write(folder, *, plays=0.0, lag=0.0, distort=lambda y, t, rng: y, seed=0, nominal=None):
    """A log of a stack of 12 um/V, at rest under 0 V before it is swept from 0 to 4 V."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, CYCLES * PERIOD, DT)
    fine = np.arange(0.0, CYCLES * PERIOD, DT / FINE)
    u = 2.0 + 2.0 * np.sin(2.0 * np.pi * fine / PERIOD)
    drive = lagged(u, lag) if lag else u
    y = 12.0 * drive
    if plays:
        radii = np.linspace(0.1, 1.9, 12)
        y = y + 12.0 * plays * sum(play(drive, r) for r in radii) / radii.size
    y = distort(y[::FINE], t, rng) - 100.0 + rng.normal(0.0, NOISE, t.size)
    folder.mkdir(parents=True)
    system = {"kind": "piezo_stack"} | ({"nominal": nominal} if nominal else {})
    document = {
        "format": 1, "name": "stack", "system": system, "controller": {"kind": "open_loop"},
        "sample_time_s": DT, "columns": {"t": "s", "u": "V", "y": "um"},
        "runs": [{"file": "run.csv", "use": "fit"}],
    }  # fmt: skip
    (folder / "logset.yaml").write_text(yaml.safe_dump(document))
    np.savetxt(folder / "run.csv", np.column_stack([t, u[::FINE], y]), delimiter=",",
               header="t,u,y", comments="", fmt="%.5f")  # fmt: skip
    return folder


def effects(result):
    return {e["id"] for e in result["effects"]}


def test_a_linear_stack_has_no_gap(tmp_path):
    result = diagnose(write(tmp_path / "set")).to_json()
    assert (result["verdict"], result["effects"]) == ("no_gap", [])
    assert result["retuned"]["gain"] == pytest.approx(12.0, rel=1e-3)


def test_a_lag_is_no_hysteresis(tmp_path):
    result = diagnose(write(tmp_path / "set", lag=0.02)).to_json()
    assert (result["verdict"], effects(result)) == ("explained", {"actuator.lag"})
    lag = result["effects"][0]["parameters"]["time_constant"]
    assert lag["ci95"][0] <= 0.02 <= lag["ci95"][1] or lag["value"] == pytest.approx(0.02, rel=0.02)


def test_plays_are_hysteresis_without_a_lag(tmp_path):
    result = diagnose(write(tmp_path / "set", plays=0.4)).to_json()
    assert (result["verdict"], effects(result)) == ("explained", {"actuator.hysteresis"})
    assert result["shrinkage"]["ci95"][0] > 90.0


@pytest.mark.slow
def test_both_are_found_beside_each_other(tmp_path):
    result = diagnose(write(tmp_path / "set", plays=0.4, lag=0.02)).to_json()
    assert result["verdict"] == "explained"
    assert effects(result) == {"actuator.lag", "actuator.hysteresis"}


def test_gain_and_scale_are_twins_in_open_loop(tmp_path):
    folder = write(tmp_path / "set", nominal={"gain_um_per_V": 10.0, "offset_um": -100.0})
    result = diagnose(folder).to_json()
    assert result["verdict"] == "ambiguous"
    assert effects(result) == {"actuator.torque_constant", "sensor.scale"}


@pytest.mark.parametrize(
    "distort",
    [
        lambda y, t, rng: y + np.cumsum(rng.normal(0.0, 0.1, t.size)),  # a wandering sensor
        lambda y, t, rng: y + 1.5 * np.sin(2.0 * np.pi * 7.3 * t),  # a hum
    ],
    ids=["wandering", "hum"],
)
def test_what_no_form_makes_is_not_explained(tmp_path, distort):
    result = diagnose(write(tmp_path / "set", distort=distort)).to_json()
    assert (result["verdict"], result["effects"]) == ("unexplained", [])


def test_cycles_are_seen_in_the_command():
    t = np.arange(1000) * DT
    assert cycle(np.sin(2.0 * np.pi * t)) == 200
    assert cycle(t) is None


def test_units_and_controller_are_checked(tmp_path):
    folder = write(tmp_path / "set")
    document = yaml.safe_load((folder / "logset.yaml").read_text())
    for change, text in (
        ({"columns": {"t": "s", "u": "V", "y": "m"}}, "the unit is 'm'"),
        ({"controller": {"kind": "pid"}}, "expected open_loop"),
        ({"system": {"kind": "piezo_stack", "nominal": {"gain": 1.0}}}, "unknown key 'gain'"),
    ):
        (folder / "logset.yaml").write_text(yaml.safe_dump(document | change))
        with pytest.raises(InputError, match=text):
            read_machine(load_logset(folder))


def test_the_measured_stage_shows_hysteresis_with_creep_behind_a_lag(shared_data):
    result = diagnose(shared_data / "piezo_hysteresis").to_json()
    assert result["verdict"] == "explained"
    assert effects(result) == {"actuator.lag", "actuator.hysteresis"}
    found = {e["id"]: e["parameters"] for e in result["effects"]}
    # Poled ceramics creep by one to two per cent a decade (Kuhnen 2003).
    assert 0.01 < found["actuator.hysteresis"]["creep_per_decade"]["value"] < 0.02
    assert result["shrinkage"]["percent"] > 95.0
