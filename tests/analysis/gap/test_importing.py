"""The import wizard: guesses with reasons, questions where unsure, a log set that can be read."""

import json
import re

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from gapscope.analysis.cli import app
from gapscope.analysis.commands import importing as command
from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.importing import carry_out, description, make_plan
from gapscope.analysis.gap.importing.clock import sample_time
from gapscope.analysis.gap.importing.units import factor
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import columns_of, read_machine

T = 0.002 * np.arange(600)
DEG = np.pi / 180.0


def write(path, header, *columns):
    np.savetxt(
        path, np.column_stack(columns), delimiter=",", header=header, comments="", fmt="%.15g"
    )
    return path


@pytest.fixture
def motors(tmp_path):
    """A log as a lab writes it: milliseconds, degrees, names of its own."""
    left, right = 90.0 * np.sin(9.0 * T), 45.0 * np.cos(9.0 * T)
    return write(
        tmp_path / "lab.csv",
        "time [ms],target_left [deg],target_right [deg],enc_left [deg],enc_right [deg],trq_left [mNm],trq_right [mNm],temp",
        1e3 * T, left, right, left - 0.1, right - 0.1, 10.0 * left, 10.0 * right, 20.0 + T,
    )  # fmt: skip


def run(*arguments, **options):
    return CliRunner().invoke(app, [str(a) for a in arguments], **options)


def test_roles_units_and_joints_are_guessed_and_converted(motors, nominal_logset, tmp_path):
    given = ("--model", nominal_logset, "--controller", "pd", "--out", tmp_path / "set", "--yes")
    done = run("import", motors, *given)
    assert done.exit_code == 0, done.output + str(done.exception)
    log = load_logset(tmp_path / "set")
    assert log.dt == 0.002
    columns = log.runs[0].columns
    np.testing.assert_allclose(columns["t"], T, atol=1e-12)
    np.testing.assert_allclose(columns["psi_L_ref"], 90.0 * DEG * np.sin(9.0 * T), atol=1e-12)
    np.testing.assert_allclose(columns["psi_R"], DEG * (45.0 * np.cos(9.0 * T) - 0.1), atol=1e-12)
    np.testing.assert_allclose(columns["tau_L"], 0.9 * np.sin(9.0 * T), atol=1e-12)
    assert read_machine(log)[0].kind == "c_drive"


def test_what_is_not_sure_is_not_taken_without_a_word(tmp_path):
    log = write(tmp_path / "a.csv", "t,soll,ist,f", T, np.sin(T), np.sin(T - 0.01), np.cos(T))
    out = tmp_path / "set"
    for extra, words in (((), "force"), (("--column", "force=f"), "no unit stated")):
        done = run("import", log, "--kind", "slider", "--out", out, *extra)
        assert isinstance(done.exception, InputError)
        assert words in str(done.exception)
        assert not out.exists()
    columns = ("--column", "force=f:N", "--column", "q_ref=soll:mm", "--column", "q=ist:mm")
    done = run("import", log, "--kind", "slider", "--out", out, *columns)
    assert done.exit_code == 0, str(done.exception)
    np.testing.assert_allclose(
        np.loadtxt(out / "a.csv", delimiter=",", skiprows=1)[:, 1], 1e-3 * np.sin(T)
    )
    assert "state system" in done.output


def test_the_wizard_asks_for_what_it_did_not_find(tmp_path, monkeypatch):
    monkeypatch.setattr(command, "_interactive", lambda: True)
    log = write(tmp_path / "a.csv", "t,q_ref,q,f", T, np.sin(T), np.sin(T - 0.01), np.cos(T))
    done = run("import", log, "--kind", "slider", "--out", tmp_path / "set", input="f:kN\ny\n")
    assert done.exit_code == 0, done.output + str(done.exception)
    table = np.loadtxt(tmp_path / "set" / "a.csv", delimiter=",", skiprows=1)
    np.testing.assert_allclose(table[:, 3], 1e3 * np.cos(T))
    refused = run("import", log, "--kind", "slider", "--out", tmp_path / "no", input="f:kN\nn\n\n")
    assert refused.exit_code == 1
    assert not (tmp_path / "no").exists()


def test_an_unnamed_reference_is_the_earlier_of_two_equal_signals(tmp_path):
    log = write(tmp_path / "a.csv", "t,pos_b,pos_a", T, np.sin(9.0 * T - 0.1), np.sin(9.0 * T))
    guesses = {g.source.column: g for g in make_plan(log, None).guesses}
    assert guesses["pos_a"].role == "reference"
    assert guesses["pos_a"].sure < 0.8
    assert guesses["pos_b"].role == "position"


def test_uneven_clocks_are_resampled_only_when_asked_and_the_log_set_says_so(tmp_path):
    t = T + 0.0006 * np.sin(1e3 * np.arange(600))
    log = write(tmp_path / "a.csv", "t,q_ref,q,force", t, np.sin(t), np.sin(t), np.cos(t))
    arguments = ("import", log, "--kind", "slider", "--yes", "--out", tmp_path / "set")
    assert "--resample" in str(run(*arguments).exception)
    done = run(*arguments, "--resample", "--sample-time", "0.002")
    assert done.exit_code == 0, str(done.exception)
    (remark,) = yaml.safe_load((tmp_path / "set" / "logset.yaml").read_text())["remarks"]
    assert "rms jitter" in remark
    assert "linear interpolation" in remark
    assert load_logset(tmp_path / "set").notes == (remark,)


def test_topics_of_two_rates_are_brought_to_the_clock_of_the_position(tmp_path):
    path = tmp_path / "log.mcap"
    with open(path, "wb") as stream:
        writer = pytest.importorskip("mcap.writer").Writer(stream)
        writer.start()
        fast, slow = (writer.register_channel(name, "json", 0) for name in ("/axis", "/drive"))
        for i, t in enumerate(T):
            at = round(1e9 * t)
            writer.add_message(
                fast, at, json.dumps({"q_ref": np.sin(t), "q": np.sin(t)}).encode(), at
            )
            if i % 2 == 1 or i == 0:
                writer.add_message(slow, at, json.dumps({"force": 3.0 * t}).encode(), at)
        writer.finish()
    plan = make_plan(path, columns_of("slider"))
    options = {"name": "x", "system": description(None, "slider")}
    with pytest.raises(InputError, match="another clock"):
        carry_out(plan, [path], **options)
    imported = carry_out(plan, [path], resample=True, **options)
    np.testing.assert_allclose(imported.tables["log.csv"]["force"], 3.0 * T, atol=1e-9)
    assert any("force" in remark for remark in imported.document["remarks"])


def test_several_files_become_runs_and_must_agree(motors, tmp_path):
    second = tmp_path / "second.csv"
    second.write_bytes(motors.read_bytes())
    plan = make_plan(motors, columns_of("c_drive"))
    options = {"name": "x", "system": description(None, "c_drive")}
    imported = carry_out(plan, [motors, second], validate=[second], form="parquet", **options)
    assert [(r["file"], r["use"]) for r in imported.document["runs"]] == [
        ("lab.parquet", "fit"), ("second.parquet", "validate"),
    ]  # fmt: skip
    slower = write(tmp_path / "slow.csv", motors.read_text().splitlines()[0],
                   *np.loadtxt(motors, delimiter=",", skiprows=1).T * np.array([2.0] + 7 * [1.0])[:, None])  # fmt: skip
    with pytest.raises(InputError, match=r"slow\.csv: samples every 0\.004 s"):
        carry_out(plan, [motors, slower], **options)


def test_a_log_without_times_needs_a_rate(tmp_path):
    q = np.sin(9.0 * T)
    log = write(tmp_path / "a.csv", "q_ref,q,force", q, q, np.cos(9.0 * T))
    with pytest.raises(InputError, match="--rate"):
        make_plan(log, columns_of("slider"))
    done = run("import", log, "--kind", "slider", "--rate", 500, "--yes", "--out", tmp_path / "s")
    assert done.exit_code == 0, str(done.exception)
    np.testing.assert_allclose(
        np.loadtxt(tmp_path / "s" / "a.csv", delimiter=",", skiprows=1)[:, 0], T
    )


@pytest.mark.parametrize(
    ("source", "target", "expected"),
    [("deg", "rad", DEG), ("°", "rad", DEG), ("mm", "m", 1e-3), ("N m", "Nm", 1.0),
     ("mN·m", "Nm", 1e-3), ("usec", "s", 1e-6), ("mm", "rad", None), ("mN", "N", 1e-3)],
)  # fmt: skip
def test_units_convert_or_do_not(source, target, expected):
    found = factor(source, target)
    assert (found is None) if expected is None else found == pytest.approx(expected)


def test_the_sample_time_is_rounded_only_where_nobody_can_see_it():
    assert sample_time(0.001 * np.arange(10_000)) == 0.001
    assert sample_time(np.arange(10_000) / 190.0) == pytest.approx(1.0 / 190.0, rel=0.02 / 10_000)
    assert sample_time(0.00100002 * np.arange(10_000)) == pytest.approx(0.00100002, rel=1e-9)


def joint_topics(path, names):
    """A log of two topics with a position of every name, one of them the reference by its topic alone."""
    with open(path, "wb") as stream:
        writer = pytest.importorskip("mcap.writer").Writer(stream)
        writer.start()
        for topic, lag in (("/joint_states", 0.01), ("/joint_reference", 0.0)):
            channel = writer.register_channel(topic, "json", 0)
            for t in T:
                fields = {f"position_{name}": np.sin(9.0 * (t - lag)) for name in names}
                if lag:
                    fields["heat"] = 20.0 + t
                at = round(1e9 * t)
                writer.add_message(channel, at, json.dumps(fields).encode(), at)
        writer.finish()
    return path


def test_a_topic_of_references_is_known_by_its_name(tmp_path):
    path = joint_topics(tmp_path / "log.mcap", "LR")
    wanted = {"psi_L_ref": "rad", "psi_L": "rad", "psi_R_ref": "rad", "psi_R": "rad", "tau_L": "Nm"}
    plan = make_plan(path, wanted)
    assert {name: str(guess.source) for name, guess in plan.columns.items()} == {
        "psi_L_ref": "/joint_reference:position_L", "psi_L": "/joint_states:position_L",
        "psi_R_ref": "/joint_reference:position_R", "psi_R": "/joint_states:position_R",
    }  # fmt: skip
    with pytest.raises(
        InputError, match=r"tau_L; expected a column for each, of /joint_states:heat"
    ):
        plan.require_all()


def test_each_run_says_which_of_several_controllers_was_running(nominal_logset, tmp_path):
    model = yaml.safe_load((nominal_logset / "logset.yaml").read_text())
    first, second = model["controllers"] = {"hard": {"kind": "pd"}, "soft": {"kind": "pd"}}
    (tmp_path / "logset.yaml").write_text(yaml.safe_dump(model))
    tables = [nominal_logset / f"run{i}.csv" for i in (1, 2)]
    given = ("import", *tables, "--model", tmp_path, "--yes", "--out", tmp_path / "set")
    for stated, words in (
        ((), r"run1\.csv: no controller is stated; expected which of hard, soft"),
        ((f"run1.csv={first}",), r"run2\.csv: no controller is stated"),
        (("stiff",), "'stiff'; expected one of hard, soft"),
        ((f"run9.csv={first}",), "'run9.csv'; expected one of .*run1"),
    ):
        done = run(*given, *(part for text in stated for part in ("--controller", text)))
        assert isinstance(done.exception, InputError)
        assert re.search(words, str(done.exception)), done.exception
        assert not (tmp_path / "set").exists()
    done = run(*given, "--controller", f"run2.csv={second}", "--controller", first)
    assert done.exit_code == 0, str(done.exception)
    runs = yaml.safe_load((tmp_path / "set" / "logset.yaml").read_text())["runs"]
    assert [entry["controller"] for entry in runs] == [first, second]


def test_a_column_the_machine_does_not_have_is_said(motors, nominal_logset, tmp_path):
    given = ("--model", nominal_logset, "--controller", "pd", "--out", tmp_path / "set", "--yes")
    done = run("import", motors, *given, "--column", "psy_L=enc_left")
    assert done.exit_code == 0, str(done.exception)
    assert "note: psy_L is no column of this machine" in done.output
    assert "psi_L is no column" not in done.output
