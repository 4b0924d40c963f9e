"""``gapscope simulate c-drive``: log set, figure and bad input."""

from pathlib import Path

import numpy as np
import pytest
import yaml
from matplotlib.figure import Figure
from typer.testing import CliRunner

from gapscope.analysis import files, simulation
from gapscope.analysis.cli import app
from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines.c_drive import read
from gapscope.diagrams import c_drive_config
from gapscope.diagrams.c_drive_config import CDriveLoopConfig
from gapscope.models import c_drive, drive_kernels, encoder


def simulate(*arguments):
    return CliRunner().invoke(app, ["simulate", "c-drive", *map(str, arguments)])


def test_command_writes_a_log_set_and_a_plot(tmp_path):
    result = simulate(
        "--controller", "ct", "--motion", "helical", "--rate", 2, "--cycles", 1, "--out", tmp_path
    )
    assert result.exit_code == 0, result.output
    assert sorted(p.name for p in tmp_path.iterdir()) == ["logset.yaml", "run1.csv", "run1.png"]
    document = yaml.safe_load((tmp_path / "logset.yaml").read_text())
    assert document["controllers"]["ct"]["kp_per_s2"] == 35000.0
    run = document["runs"][0]
    assert run == {
        "file": "run1.csv", "controller": "ct", "motion": "helical", "rate_Hz": 2.0, "use": "fit",
    }  # fmt: skip
    table = np.genfromtxt(tmp_path / "run1.csv", delimiter=",", names=True)
    assert list(table.dtype.names) == list(document["columns"])
    assert table.size == 500
    np.testing.assert_allclose(np.diff(table["t"]), document["sample_time_s"], atol=1e-9)
    counts = table["psi_L"] / encoder.resolution(13)
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-5)


@pytest.mark.parametrize("name", sorted(c_drive_config.CONTROLLERS))
def test_every_controller_has_a_block_that_repeats_its_gains(name):
    config = CDriveLoopConfig(controller=c_drive_config.CONTROLLERS[name]())
    ((key, block),) = simulation.logset_document(fake_run(config))["controllers"].items()
    assert key == name
    numbers = {value for value in block.values() if isinstance(value, float)}
    assert numbers == {float(value) for value in vars(config.controller).values() if value}


@pytest.mark.parametrize("name", sorted(c_drive_config.CONTROLLERS))
def test_the_instrument_reads_the_log_set_and_repeats_its_commands(name, tmp_path):
    """Replayed on the logged angles; 1e-9 rad of rounding times gains below 2e5 N m/rad."""
    settings = CDriveLoopConfig(
        controller=c_drive_config.CONTROLLERS[name](), motion="helical", model_error=1.05, cycles=1
    )
    simulation.write_c_drive_run(simulation.simulate_c_drive(settings), tmp_path)
    _, (run,) = read(load_logset(tmp_path))
    command = np.zeros_like(run.command)
    drive_kernels.replay_controller(
        run.reference,
        run.reference_acceleration,
        run.position,
        run.controller,
        run.dt,
        drive_kernels.initial_memory(run.controller, np.zeros(2)),
        command,
    )
    np.testing.assert_allclose(command, run.command, rtol=0, atol=2e-4)


def fake_run(config):
    empty = np.zeros((0, 2))
    signals = dict.fromkeys(("reference", "measured", "command", "torque", "position"), empty)
    return simulation.CDriveRun(config=config, t=np.zeros(0), **signals)


def test_nominal_model_is_the_one_the_controller_believes():
    config = CDriveLoopConfig(model_error=1.05)
    nominal = simulation.logset_document(fake_run(config))["system"]["nominal"]
    assert nominal["m11_kg_m2"] == pytest.approx(1.05 * c_drive.CDriveParameters.m11)


def test_collar_errors_of_the_thesis_pd_run():
    """Table 5-4, PD simulation, helical at 2 Hz: 0.1616 mm and 0.0141 rad, to the 3.5 % that the
    unprinted damping allows (ERRATA), over the second cycle."""
    run = simulation.simulate_c_drive(CDriveLoopConfig(motion="helical", rate=2.0, cycles=2))
    rms = np.sqrt(np.mean(run.collar_errors()[500:] ** 2, axis=0))
    np.testing.assert_allclose(rms, [0.1616e-3, 0.0141], rtol=0.035)


def test_progress_reaches_the_end():
    times = []
    simulation.simulate_c_drive(CDriveLoopConfig(cycles=1, rate=10.0), times.append)
    assert times == sorted(times)
    assert times[-1] == pytest.approx(0.099)


def test_diverging_gains_end_in_one_error_and_write_nothing(tmp_path):
    config = tmp_path / "loop.yaml"
    config.write_text("controller: !PD {kp: 4500.0}\n")
    result = simulate("--config", config, "--out", tmp_path / "out")
    assert isinstance(result.exception, InputError)
    assert "diverged" in str(result.exception)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("text", "word"),
    [("motoin: helical", "motoin"), ("machine: {m12: 1.0}", "m12"), ("rate: [", "YAML")],
)
def test_unusable_settings_end_in_one_error(tmp_path, text, word):
    config = tmp_path / "loop.yaml"
    config.write_text(text)
    result = simulate("--config", config, "--out", tmp_path / "out")
    assert isinstance(result.exception, InputError)
    assert word in str(result.exception)
    assert str(result.exception).count("; expected") == 1
    assert not (tmp_path / "out").exists()


def test_missing_config_and_unwritable_folder_are_named(tmp_path):
    result = simulate("--config", tmp_path / "none.yaml", "--out", tmp_path / "out")
    assert "none.yaml" in str(result.exception)
    (tmp_path / "file").write_text("")
    result = simulate("--cycles", 1, "--rate", 10, "--out", tmp_path / "file")
    assert isinstance(result.exception, InputError)


def test_a_file_that_fails_leaves_nothing_behind(tmp_path):
    def fail(path: Path) -> None:
        path.write_text("half")
        raise RuntimeError("disk on fire")

    with pytest.raises(RuntimeError, match="disk on fire"):
        files.write_folder(tmp_path / "out", {"a": lambda p: p.write_text("a"), "b": fail})
    assert not (tmp_path / "out").exists()
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "a").write_text("before")
    with pytest.raises(RuntimeError, match="disk on fire"):
        files.write_folder(tmp_path / "old", {"a": lambda p: p.write_text("a"), "b": fail})
    assert [p.name for p in (tmp_path / "old").iterdir()] == ["a"]
    assert (tmp_path / "old" / "a").read_text() == "before"


def test_an_axis_at_rest_is_drawn_at_rest(tmp_path, monkeypatch):
    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, *_, **__: drawn.append(figure))
    simulate("--motion", "rotation", "--cycles", 1, "--out", tmp_path)
    reference, error_of_u, error_of_angle = (
        drawn[0].axes[i].lines[0].get_ydata() for i in (0, 1, 2)
    )
    assert not np.any(reference)
    assert not np.any(error_of_u)
    assert np.ptp(error_of_angle) > 1.0
