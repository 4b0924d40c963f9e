"""``gapscope simulate`` of each parallel machine, and where both couplings part."""

import json
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from gapscope.analysis.cli import app
from gapscope.analysis.errors import InputError
from gapscope.analysis.gap import machines as kinds
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.mechatronic import couplings, servo_machines, servo_run
from gapscope.diagrams.servo_loop import Coupling

QUICK = {"step": 5e-4, "velocity_period": 1e-3, "position_period": 5e-3}


@pytest.mark.parametrize("name", ["5r", "2prr", "replalink", "mast", "3prs"])
def test_log_set_says_the_machine_that_was_simulated(name, tmp_path):
    """The reader of its kind builds the same equations from ``system.nominal``."""
    machine = servo_machines.servo_machine(name)
    chosen, path = servo_machines.motion(machine, None)
    loop = machine.loop() if name == "5r" else machine.loop(**QUICK)
    run = servo_run.simulate(loop, path, chosen, seconds=120 * loop.velocity_period)
    written = servo_run.write(machine, run, tmp_path / "out")
    assert sorted(p.name for p in written) == ["logset.yaml", "run1.csv", "run1.png"]
    read, (log,) = kinds.read_machine(load_logset(tmp_path / "out"))
    assert read.per_motor == pytest.approx(loop.axis.per_motor)
    assert log.position * read.per_motor == pytest.approx(run.joint_position, abs=1e-11)
    q, v = run.joint_position[-1], run.joint_rate[-1]
    ours, said = loop.machine.equations(q, v), read.chain.equations(q, v)
    assert said.inertia == pytest.approx(ours.inertia, rel=1e-9, abs=1e-12)
    assert said.gravity == pytest.approx(ours.gravity, rel=1e-6, abs=1e-9)


def test_couplings_agree_to_first_order_below_an_inertia_ratio_of_one():
    """Half the step, half the difference; above a ratio of one, at any step, only the one plant is left."""
    machine = servo_machines.servo_machine("2prr")
    chosen, path = servo_machines.motion(machine, None)
    own = machine.loop(**QUICK)
    own = replace(own, axis=replace(own.axis, coulomb=0.0))  # its sign needs a smaller step
    assert couplings.inertia_ratio(own, path) == pytest.approx(0.19, abs=0.02)
    low, high, over = (
        couplings.compare(
            chosen, couplings.geared(own, path, ratio), path, ratio, own=False, seconds=0.1
        )
        for ratio in (0.2, 0.8, 1.2)
    )
    for row in (low, high):
        assert row.apart_half_step / row.apart == pytest.approx(0.5, abs=0.15)
    assert low.apart < high.apart < 1e-3
    assert over.apart is None
    assert over.apart_half_step is None
    assert over.plant_error < 1.0
    assert couplings.table([low, over]).row_count == 2


def test_couplings_are_written_and_drawn(tmp_path):
    common = {"per_motor": 1.0, "step": 1e-3, "plant_error": 0.1, "own": False}
    rows = [
        couplings.Row(machine=name, ratio=ratio, apart=apart, apart_half_step=apart, **common)
        for name in servo_machines.MACHINES
        for ratio, apart in ((0.1, 1e-4), (2.0, None))
    ]
    data, figure = couplings.write(rows, tmp_path / "out")
    assert json.loads(data.read_text())["rows"][1]["apart"] is None
    assert figure.stat().st_size > 10_000


def test_divergence_is_one_error_that_names_the_other_coupling():
    machine = servo_machines.servo_machine("replalink")
    chosen, path = servo_machines.motion(machine, None)
    loop = machine.loop(coupling=Coupling.disturbance)
    with pytest.raises(InputError, match="--coupling plant"):
        servo_run.simulate(loop, path, chosen, seconds=0.1)


def test_command_runs_end_to_end(tmp_path):
    out = tmp_path / "out"
    done = CliRunner().invoke(app, ["simulate", "replalink", "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert {p.name for p in out.iterdir()} == {"run1.csv", "run1.png", "logset.yaml"}
    rows = np.loadtxt(out / "run1.csv", delimiter=",", skiprows=1)
    assert rows.shape[1] == 7


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["simulate", "2prr", "--motion", "x-move"], "one of pick-and-place, circle"),
        (["simulate", "mast", "--current-bandwidth", "100"], "with 5r alone"),
        (["simulate", "5r", "--current-bandwidth", "9000"], "at most 3200 Hz"),
    ],
)
def test_wrong_options_are_one_error(arguments, said, tmp_path):
    done = CliRunner().invoke(app, [*arguments, "--out", str(tmp_path / "out")])
    assert isinstance(done.exception, InputError)
    assert said in str(done.exception)
