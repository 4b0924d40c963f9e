"""The claims of the resolved-acceleration study, each with a number that could refute it."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

from gapscope.analysis import resolved_acceleration as study
from gapscope.analysis.cli import app
from gapscope.analysis.errors import InputError
from gapscope.analysis.simulation import simulate_c_drive
from gapscope.diagrams import c_drive_config as config
from gapscope.models.drive import GAIN

KP, KD = study.TUNED.kp, study.TUNED.kd
AS_PRINTED = config.Amplifier(delay=study.PRINTED.delay, lag=study.PRINTED.lag)


@pytest.fixture(scope="module")
def trials():
    return {trial.name: trial for trial in study.trials()}


def test_the_stable_gains_form_a_rectangle():
    """Growth of a pair is that of the worse direction, each searched beside a weak other one."""
    rng, machine = np.random.default_rng(4), study.plant()
    weak = 0.3 * KP  # well damped, so that it never decides
    for _ in range(10):
        t, r = KP * rng.uniform(0.7, 2.5, 2)
        alone = [
            study.mode(study.gains(t, weak), machine),
            study.mode(study.gains(weak, r), machine),
        ]
        pair = study.mode(study.gains(t, r), machine)
        assert pair.growth == pytest.approx(max(mode.growth for mode in alone), abs=1e-6)


def test_the_rectangle_is_a_matter_of_symmetry():
    """A left-right mismatch couples the directions; this is what the test above could see."""
    machine = study.plant()
    machine.shaft[:, GAIN] = [1.3, 0.7]
    t, r = 1.3 * KP, 0.8 * KP
    alone = [study.mode(study.gains(*g), machine).growth for g in ((t, 0.3 * KP), (0.3 * KP, r))]
    assert abs(study.mode(study.gains(t, r), machine).growth - max(alone)) > 0.1


def test_printed_gains_lie_at_the_limit_of_the_printed_torque_path():
    """Gains tuned "just below the limit": 0.9 to 1.02 of it, 2 % for the accuracy of the model."""
    gains = {gain.name: gain for gain in study.tuned_gains(study.PRINTED)}
    for name in ("PD", "CT translation", "CT rotation"):
        assert 0.9 < gains[name].share < 1.02
    assert 0.6 < gains["TS rotation"].share < 0.8  # not at its limit: stated as unexplained


def test_the_ideal_torque_path_shows_no_limit_near_the_printed_gains(trials):
    assert all(gain.share < 0.4 for gain in study.tuned_gains(study.TORQUE_PATHS[0]))
    assert trials["rotation gains 2.5 times, ideal torque path"].growth < 0.0


def test_raising_one_gain_is_unstable_and_lowering_one_is_not(trials):
    for name in ("rotation gains 2.5 times", "rotation kp 2.5 times", "translation kp 2.5 times"):
        assert trials[name].growth > 20.0
    for name in ("rotation kp 2.5 times down", "translation kp 2.5 times down"):
        assert trials[name].growth < 0.0


def test_other_explanations_fail(trials):
    """Wrong units and unlike motors stay stable; soft couplings take equal gains with them."""
    assert trials["gains of the TS column taken as 1/s^2"].growth < 0.0
    assert trials["motors 30 % unlike, kp 28000 and 14000"].growth < 0.0
    assert trials["motors 0.5 ms apart, kp 28000 and 14000"].growth < 0.0
    for kind in ("equal", "unequal"):
        label = "couplings of {} N m/rad, {} kp below the limits"
        assert trials[label.format(100, kind)].growth > 0.0
        assert trials[label.format(3000, kind)].growth < 0.0


def test_stiff_couplings_tend_to_the_rigid_drive():
    elastic = study.elastic_plant(3e4, 0.5, 3e-4)
    pair = study.gains(0.8 * KP, 0.8 * KP)
    rigid = study.mode(pair, study.plant())
    assert study.mode(pair, elastic, substeps=64).growth == pytest.approx(rigid.growth, rel=0.05)


@pytest.mark.parametrize(
    ("factor", "path", "diverges"),
    [
        (study.RATIO, AS_PRINTED, True),
        (0.4, AS_PRINTED, False),
        (study.RATIO, config.Amplifier(), False),
    ],
    ids=["raised", "lowered", "raised, ideal path"],
)
def test_the_drake_loop_with_its_encoder_does_what_the_eigenvalues_say(factor, path, diverges):
    """Growth of 45 1/s takes one count of 0.8 mrad to tens of radians within 0.5 s."""
    settings = config.CDriveLoopConfig(
        controller=config.ResolvedAcceleration(
            kp_translation=0.8 * KP if factor < 1.0 else KP, kp_rotation=factor * KP
        ),
        amplifier=path,
        cycles=2,
    )
    if diverges:
        with pytest.raises(InputError, match="diverged"):
            simulate_c_drive(settings)
    else:
        run = simulate_c_drive(settings)
        assert np.abs(run.reference - run.position).max() < 0.1


def test_a_gain_without_a_limit_is_refused():
    with pytest.raises(ValueError, match="becomes unstable as the gain rises"):
        study.largest_stable(lambda k: -1.0, 1.0)


def test_command_writes_the_study(tmp_path, monkeypatch):
    whole = study.study
    monkeypatch.setattr(study, "study", lambda: whole(points=5))
    result = CliRunner().invoke(app, ["compare", "resolved-acceleration", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    found = json.loads((tmp_path / "resolved_acceleration.json").read_text())
    assert np.shape(found["map"]["growth"]) == (5, 5)
    assert found["limits"]["as printed"][0]["share"] == pytest.approx(0.93, abs=0.01)
    assert found["not_explained"]
    assert {p.name for p in tmp_path.iterdir()} == {
        "resolved_acceleration.json", "stability_map.png", "tuned_gains.png",
    }  # fmt: skip
