"""The benchmarks' arithmetic, agreement, files and what is skipped; never how fast this machine is."""

import json
import sys
from dataclasses import replace
from itertools import chain, repeat
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from gapscope.analysis.benchmarks import (
    c_loop,
    closed_loop,
    diagnosis,
    first_diagnosis,
    fit_peers,
    growth,
    mechanisms,
    monte_carlo,
    one_fit,
    report,
    rounds,
    start_up,
    study,
)
from gapscope.analysis.cli import app
from gapscope.analysis.errors import InputError
from gapscope.models import drive, drive_kernels

SAMPLES = 60


def test_rounds_are_interleaved_and_their_order_rotates():
    now, calls = [0.0], []

    def job(name, seconds):
        def run():
            now[0] += seconds
            calls.append(name)

        return rounds.Contender(name=name, run=run)

    jobs = [job("a", 2.0), job("b", 0.004)]
    seconds, repeats = rounds.measure(jobs, 2, lambda: now[0])
    assert repeats == [1, 3]  # 3 x 4 ms fill a block of 10 ms
    assert "".join(calls) == "ab" + "abbb" + "bbba"
    np.testing.assert_allclose(seconds, [[2.0, 0.004]] * 2)


def test_ratios_are_formed_within_rounds():
    """A round in which the machine is ten times slower for all leaves the ratios as they are."""
    jobs = [rounds.Contender(name=name, run=dict) for name in "ab"]
    seconds = np.array([[2.0, 1.0], [20.0, 10.0], [6.0, 2.0]])
    a, b = rounds.rows(jobs, seconds, [1, 1], [("", True)] * 2, "b")
    assert (a.median_s, a.ratio) == (6.0, 2.0)
    assert a.ratio_low == pytest.approx(2.0)
    assert a.ratio_high == pytest.approx(2.8)
    assert (b.ratio, b.ratio_low, b.ratio_high) == (1.0, 1.0, 1.0)


@pytest.fixture(scope="module")
def measured():
    return closed_loop.closed_loop(2, SAMPLES)


def test_all_loops_agree(measured):
    assert {row.name for row in measured.rows} >= {
        closed_loop.OURS,
        closed_loop.DRAKE,
        closed_loop.BLOCKS,
        closed_loop.PYTHON,
        "Drake, plain Python leaves",
        "Drake C++ primitives",
    }
    assert [row.name for row in measured.rows if not row.agrees] == []
    assert all(row.median_s > 0.0 for row in measured.rows)


def test_a_wrong_loop_is_found(monkeypatch):
    """One part in a billion of one constant is beyond the tolerance."""
    true = closed_loop.c_constants
    factor = np.ones(12)
    factor[4] += 1e-9  # dry friction of the motors
    monkeypatch.setattr(closed_loop, "c_constants", lambda config: factor * true(config))
    rows = {row.name: row for row in closed_loop.closed_loop(1, SAMPLES).rows}
    if closed_loop.C not in rows:
        pytest.skip("no C compiler")
    assert not rows[closed_loop.OURS].agrees


def test_plain_python_runs_no_compiled_kernel():
    space = closed_loop.interpreted(drive_kernels, "simulate").__globals__
    kernels = [name for name, value in vars(drive_kernels).items() if hasattr(value, "py_func")]
    assert {"closed_loop", "control_step", "advance", "rest"} <= set(kernels)
    assert [name for name in kernels if hasattr(space[name], "py_func")] == []


@pytest.mark.parametrize(
    ("cc", "words"), [("no-such-cc", "no-such-cc is not on the PATH"), ("false", "failed")]
)
def test_c_is_skipped_by_name_without_a_working_compiler(monkeypatch, cc, words):
    monkeypatch.setenv("CC", cc)
    group = closed_loop.closed_loop(1, SAMPLES)
    reasons = {skipped.name: skipped.reason for skipped in group.skipped}
    assert words in reasons[closed_loop.C]
    assert group.reference == closed_loop.OURS


def test_peers_that_are_not_installed_are_skipped_by_name(monkeypatch):
    absent = ("mujoco", "control", "pathsim", "bdsim")
    for name in absent:
        monkeypatch.setitem(sys.modules, name, None)
    group = closed_loop.closed_loop(1, SAMPLES)
    reasons = {skipped.name: skipped.reason for skipped in group.skipped}
    assert {name for name in absent if any(name in text for text in reasons.values())} == {*absent}
    assert {row.name for row in group.rows}.isdisjoint(reasons)
    assert "gapscope[bench]" in reasons["PathSim"]


def test_all_batches_agree_and_a_wrong_one_is_found(monkeypatch):
    """Seven sets fill no block of lanes; one part in a million of one set's friction is found."""
    group = monte_carlo.monte_carlo(1, 7, SAMPLES)
    assert [row.name for row in group.rows if not row.agrees] == []
    assert {row.name for row in group.rows} | {one.name for one in group.skipped} == {
        monte_carlo.OURS,
        monte_carlo.JAX,
        monte_carlo.C,
        monte_carlo.ROLLOUT,
    }
    if monte_carlo.C in {one.name for one in group.skipped}:
        pytest.skip("no C compiler")
    true = monte_carlo.c_batch
    factor = np.ones((7, 6))
    factor[6, 4] += 1e-6
    monkeypatch.setattr(monte_carlo, "c_batch", lambda r, table, c: true(r, factor * table, c))
    rows = {row.name: row for row in monte_carlo.monte_carlo(1, 7, SAMPLES).rows}
    assert not rows[monte_carlo.OURS].agrees


def test_the_exponent_is_found_and_held_to_linear(monkeypatch):
    """Costs of size^1 and size^2; only what has to be linear is held to it."""

    def measured(contenders, rounds):
        sizes = np.array([float(one.name.split()[-1]) for one in contenders])
        powers = np.array([2.0 if "square" in one.name else 1.0 for one in contenders])
        return np.tile(1e-6 * sizes**powers, (rounds, 1)), [1] * len(contenders)

    monkeypatch.setattr(growth, "measure", measured)
    axes = tuple(
        growth.Axis(name, (10, 100, 1000), lambda size: dict, linear)
        for name, linear in (("line", True), ("square", True), ("free square", False))
    )
    checks = {row.name: (row.check, row.agrees) for row in growth.growth(2, axes).rows}
    assert checks["line: 1000"] == ("exponent 1.00", True)
    assert checks["square: 1000"] == ("exponent 2.00", False)
    assert checks["free square: 1000"] == ("exponent 2.00", True)
    assert checks["line: 10"] == ("", True)


def test_models_of_all_robots_agree():
    group = mechanisms.mechanisms(1, samples=20, postures=20)
    assert [row.name for row in group.rows if not row.agrees] == []
    names = [row.name for row in group.rows] + [one.name for one in group.skipped]
    for robot in ("PMC", "5R", "MAST", "MM3A"):
        kinds = {name.removeprefix(f"{robot} ") for name in names if name.startswith(robot)}
        assert kinds == {"reduced", "projected plant", "SAP plant", "displacement"}
    assert [one.name for one in group.skipped] == ["MAST SAP plant"]
    assert "cross1" in group.skipped[0].reason


def test_a_wrong_model_of_a_robot_is_found(monkeypatch):
    """One part in a million of the force, which only the reduced model gets."""
    five = mechanisms.mechanism_models.robots()[1]
    wrong = replace(five, reduced=lambda q, f, n, dt: five.reduced(q, (1.0 + 1e-6) * f, n, dt))
    monkeypatch.setattr(mechanisms.mechanism_models, "robots", lambda: [wrong])
    rows = {row.name: row.agrees for row in mechanisms.mechanisms(1, 20, 20).rows}
    assert not rows["5R projected plant"]
    assert rows["5R displacement"]


def test_the_fast_c_batch_leaves_subnormal_numbers_on():
    """Linked with -ffast-math it would switch them off in the whole process."""
    try:
        c_loop._load("c_drive_batch", c_loop.BATCH_FLAGS, integers=2, arrays=4)
    except c_loop.NoCompilerError as error:
        pytest.skip(str(error))
    assert np.float64(np.finfo(float).tiny) / 4.0 > 0.0


def test_c_source_comes_with_the_package():
    reference = np.zeros((3, 2))
    constants = closed_loop.c_constants(closed_loop.task())
    try:
        run = c_loop.c_loop(reference, constants)
    except c_loop.NoCompilerError as error:
        pytest.skip(str(error))
    assert [signal.tolist() for signal in run()] == [[[0.0, 0.0]] * 3] * 2


def test_files_hold_what_was_measured(measured, tmp_path):
    machine = report.machine()
    paths = report.write([measured], machine, report.machine(), tmp_path / "out")
    assert sorted(path.name for path in paths) == ["bench.json", "bench.png"]
    document = json.loads(paths[0].read_text())
    assert document["groups"] == [json.loads(json.dumps(measured.to_json()))]
    assert document["machine"]["versions"].keys() == {"gapscope", "drake", "numpy", "numba"}


def test_nothing_is_written_if_the_plot_fails(measured, tmp_path, monkeypatch):
    def fail(groups, path):
        raise RuntimeError("no plot")

    monkeypatch.setattr(report, "plot", fail)
    with pytest.raises(RuntimeError, match="no plot"):
        report.write([measured], report.machine(), report.machine(), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_command_says_what_is_skipped(tmp_path, monkeypatch):
    monkeypatch.delenv("GAPSCOPE_DATA", raising=False)
    monkeypatch.setenv("COLUMNS", "200")
    out = tmp_path / "bench"
    done = CliRunner().invoke(app, ["bench", "--out", str(out), "--quick", "--group", "diagnosis"])
    assert done.exit_code == 0, done.output
    assert "give --open DIR" in done.stdout
    (group,) = json.loads((out / "bench.json").read_text())["groups"]
    assert [row["name"] for row in group["skipped"]] == ["open sets"]
    assert (out / "bench.png").is_file()


def test_disagreement_ends_in_exit_code_1(tmp_path, monkeypatch):
    row = rounds.Row(
        name="x", median_s=1.0, low_s=1.0, high_s=1.0, ratio=None, ratio_low=None,
        ratio_high=None, repeats=1, check="differs by 1", agrees=False,
    )  # fmt: skip
    group = rounds.Group(name="g", task="t", rounds=1, reference=None, agreement="", rows=(row,))
    monkeypatch.setattr(study, "measured", lambda *_: group)
    monkeypatch.setenv("COLUMNS", "200")
    done = CliRunner().invoke(app, ["bench", "--out", str(tmp_path), "--group", "start-up"])
    assert done.exit_code == 1
    assert "DISAGREES" in done.stdout


def test_a_stated_folder_without_log_sets_is_refused(tmp_path):
    with pytest.raises(InputError, match="--open: no log sets"):
        study.measured(diagnosis.NAME, True, tmp_path)


def test_diagnoses_that_differ_are_found(tmp_path, monkeypatch):
    (tmp_path / "a").mkdir()
    (tmp_path / "a" / "logset.yaml").touch()
    verdicts = repeat("explained")

    def result():
        return {"verdict": next(verdicts), "effects": [], "provenance": {"simulations": 7}}

    monkeypatch.setattr(diagnosis, "_diagnose", lambda path: result)
    (row,) = diagnosis.diagnosis(tmp_path, 1).rows
    assert row.agrees
    assert row.check.startswith("explained; 7 simulations")
    verdicts = chain(["explained"], repeat("ambiguous"))
    (row,) = diagnosis.diagnosis(tmp_path, 1).rows
    assert not row.agrees


def test_groups_that_need_a_log_set_are_skipped_without_it(tmp_path):
    for group in (one_fit.one_fit(tmp_path, 1), first_diagnosis.first_diagnosis(None, 1)):
        assert group.rows == ()
        assert "give --open DIR" in group.skipped[0].reason


@pytest.fixture(scope="module")
def fitted_log():
    """What a drive of known numbers does under a wave of torque, read without error."""
    numbers = fit_peers.Numbers([[900.0, 100.0], [100.0, 900.0]], [4e-3] * 3, [0.05] * 3, [0.5] * 3)
    t = 1e-3 * np.arange(80)
    command = np.column_stack([np.sin(60.0 * t), np.cos(45.0 * t)])
    state, position = [0.0, 0.0, 0.0, 0.0], []
    for torque in command:
        position.append(state[:2])
        state = fit_peers.ode4(numbers, state, torque, 1e-3)
    return numbers, fit_peers.log_of(np.array(position), command, 1e-3, 100.0)


@pytest.mark.parametrize("peer", ["ours", "drake", "mujoco"])
def test_every_predictor_finds_a_true_model_without_error(peer, fitted_log):
    """and sees one part in a hundred of the dry friction of the collar."""
    numbers, log = fitted_log
    if peer == "ours":

        def residual(n):
            plant = drive.ideal_drive(
                np.linalg.inv(n.inverse), [[1, 0], [0, 1], [1, -1]], n.viscous, 0.5
            )
            plant.element[:, drive.FORWARD] = plant.element[:, drive.BACKWARD] = n.level
            error = np.empty_like(log.position)
            drive_kernels.predict(log.position, log.command, plant, log.dt, 1, 100.0, error)
            return error

    else:
        if peer == "mujoco":
            pytest.importorskip("mujoco")
        residual = {"drake": fit_peers.by_drake, "mujoco": fit_peers.by_mujoco}[peer](log)
    scale = np.abs(log.position).max()
    assert np.abs(residual(numbers)).max() < 1e-11 * scale
    wrong = numbers._replace(level=[0.05, 0.05, 0.0505])
    assert np.abs(residual(wrong)).max() > 1e-8 * scale


def test_start_up_needs_the_right_output(monkeypatch):
    done = SimpleNamespace(returncode=0, stdout="")
    monkeypatch.setattr(start_up.subprocess, "run", lambda *_, **__: done)
    agrees = {row.name: row.agrees for row in start_up.start_up(1).rows}
    assert agrees == {start_up.BARE: True, start_up.NUMPY: True, start_up.HELP: False}
