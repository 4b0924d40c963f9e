"""Wrong signals are found by replaying the controller, before anything is blamed on the machine."""

from dataclasses import replace

import numpy as np
import pytest

from gapscope.analysis.gap import signals
from gapscope.analysis.gap.hypothesis import Fit, Hypothesis
from gapscope.analysis.gap.log_faults import OTHER_UNIT, log_faults
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine, stated_encoder_step
from gapscope.analysis.gap.signals import examine


@pytest.fixture(scope="module")
def case(nominal_logset):
    log = load_logset(nominal_logset)
    machine, runs = read_machine(log)
    return machine, runs, stated_encoder_step(log)


def found(case, change):
    machine, runs, lsb = case
    _, findings = examine(machine, [change(run) for run in runs], lsb)
    return {f.effect: f for f in findings}


def test_a_good_log_has_no_findings(case):
    assert found(case, lambda run: run) == {}


@pytest.mark.parametrize("samples", [1, 2, -1])
def test_a_clock_offset_of_the_positions(case, samples):
    def late(run):
        return replace(run, position=np.roll(run.position, samples, axis=0))

    finding = found(case, late)["sensor.timing"]
    assert finding.form == "positions late"
    assert finding.parameters["late"]["value"] == pytest.approx(1e-3 * samples, abs=1e-4)


def test_an_offset_of_the_logged_position(case):
    findings = found(case, lambda run: replace(run, position=run.position + np.array([0.02, 0.0])))
    assert set(findings) == {"sensor.offset"}
    finding = findings["sensor.offset"]
    assert finding.where == {"joints": ["left"]}
    assert finding.parameters["offset_left"]["value"] == pytest.approx(0.02, abs=1e-4)


def test_an_offset_that_saturates_the_replayed_controller(case):
    def shifted(run):
        limited = run.controller._replace(limit=1.01 * np.max(np.abs(run.command)))
        return replace(run, position=run.position + 1.0, controller=limited)

    finding = found(case, shifted)["sensor.offset"]
    assert finding.parameters["offset_right"]["value"] == pytest.approx(1.0, abs=1e-3)


def test_a_scale_of_the_logged_position(case):
    finding = found(case, lambda run: replace(run, position=run.position * [1.0, 1.01]))
    assert finding["sensor.scale"].parameters["scale_error_right"]["value"] == pytest.approx(
        0.01, abs=1e-4
    )


def test_a_coarser_encoder_than_stated(case):
    machine, runs, lsb = case
    coarse = [replace(run, lsb=8.0 * run.lsb) for run in runs]
    _, findings = examine(machine, coarse, lsb)
    assert [f.effect for f in findings] == ["sensor.quantisation"]


def test_readings_that_start_off_and_are_driven_back_are_a_home_offset(case):
    """The loop sees the offset: it starts with it and then drives the reading to the reference."""

    def homed_wrong(run):
        decay = np.exp(-run.t / 0.02)[:, None]
        return replace(run, position=run.position + 0.02 * decay * [1.0, 0.0])

    machine, runs, _ = case
    finding = signals._home_offset(machine, [homed_wrong(run) for run in runs if run.use == "fit"])
    assert finding[0].form == "home offset"
    assert finding[0].where == {"joints": ["left"]}


def test_a_machine_that_sags_under_a_load_has_no_home_offset(case):
    machine, runs, _ = case
    sagging = [replace(r, position=r.position + 0.02) for r in runs if r.use == "fit"]
    assert signals._home_offset(machine, sagging) == []


def test_noise_of_the_first_readings_is_no_home_offset(case):
    machine, runs, _ = case
    chance = np.random.default_rng(0)
    noisy = [
        replace(run, position=run.reference + chance.normal(0.0, 2e-3, run.position.shape))
        for run in runs
        if run.use == "fit"
    ]
    for run, first in zip(noisy, (3.1e-3, 3.0e-3, 2.9e-3, 3.0e-3)):
        run.position[0] = run.reference[0] + first  # alike by chance, within the noise
    assert signals._home_offset(machine, [replace(run, lsb=1e-4) for run in noisy]) == []
    far = [replace(run, lsb=1e-4, position=run.position.copy()) for run in noisy]
    for run in far:
        run.position[:50] += 0.02
    assert signals._home_offset(machine, far) != []


@pytest.mark.parametrize("samples", [1, -1])
def test_a_clock_offset_of_the_command(case, samples):
    def moved(run):
        return replace(run, command=np.roll(run.command, -samples, axis=0))

    findings = found(case, moved)
    assert set(findings) == {"sensor.timing"}
    assert findings["sensor.timing"].form == "command early"
    early = findings["sensor.timing"].parameters["early"]["value"]
    assert early == pytest.approx(1e-3 * samples, abs=1e-4)


def test_a_command_in_amperes_that_is_said_to_be_a_torque(case):
    findings = found(case, lambda run: replace(run, command=run.command / 0.4))
    assert set(findings) == {"sensor.scale"}
    finding = findings["sensor.scale"]
    assert finding.form == "scale of the command in the log"
    assert finding.parameters["scale_error"]["value"] == pytest.approx(1.5, rel=1e-3)


def test_positions_and_reference_in_degrees_said_to_be_radians(case):
    def in_degrees(run):
        signals = ("position", "reference", "reference_rate", "reference_acceleration")
        turned = {name: np.degrees(getattr(run, name)) for name in signals}
        return replace(run, **turned, lsb=np.degrees(run.lsb))

    findings = found(case, in_degrees)
    assert set(findings) == {"sensor.scale"}  # and no coarser encoder
    finding = findings["sensor.scale"]
    assert finding.form == "positions and reference in another unit"
    factor = 1.0 + finding.parameters["scale_error"]["value"]
    assert factor == pytest.approx(180.0 / np.pi, rel=1e-3)


def test_a_right_log_is_kept_where_the_stated_controller_is_not_the_one_that_ran(case):
    """Gains of 0.4 times the true ones: the command would fit them if it were smaller, the machine would not."""
    machine, runs, lsb = case
    weak = [
        replace(run, controller=run.controller._replace(output=0.4 * run.controller.output))
        for run in runs
    ]
    corrected, findings = examine(machine, weak, lsb)
    assert findings == []
    assert all(a.command is b.command for a, b in zip(corrected, weak))


def test_the_end_of_a_lone_run_decides_nothing(case):
    machine, runs, lsb = case
    cut = len(runs[0].t) * 2 // 3
    spoilt = runs[0].position.copy()
    spoilt[cut:] += 0.05
    lone = replace(runs[0], position=spoilt, window=slice(0, cut))
    assert examine(machine, [lone], lsb)[1] == []


def test_faults_of_what_the_model_is_driven_by_must_help_the_model(case):
    machine, runs, lsb = case
    for joints in (machine.joints, machine.joints[:1]):
        one = [
            replace(
                r, position=r.position[:, : len(joints)], reference=r.reference[:, : len(joints)]
            )
            for r in runs
        ]
        faults = log_faults(replace(machine, joints=joints), one, lsb)
        assert {f.form for f in faults if f.in_model} == {
            "command early", "scale of the command in the log", OTHER_UNIT,
        }  # fmt: skip


def test_a_command_of_the_other_sign(case):
    findings = found(case, lambda run: replace(run, command=-run.command))
    assert set(findings) == {"sensor.scale"}
    factor = 1.0 + findings["sensor.scale"].parameters["scale_error"]["value"]
    assert factor == pytest.approx(-1.0, abs=1e-3)


def in_mid_motion(run, first=150):
    signals = ("t", "reference", "reference_rate", "reference_acceleration", "position", "command")
    return replace(run, **{name: getattr(run, name)[first:] for name in signals})


def test_a_log_that_starts_in_motion_has_no_home_offset_and_settles(case):
    machine, runs, _ = case
    moving = [in_mid_motion(run) for run in runs if run.use == "fit"]
    late = [
        replace(run, position=run.position - 0.02 * np.exp(-run.t / 0.05)[:, None])
        for run in moving
    ]
    assert signals._home_offset(machine, late) == []
    assert all(machine.settling(run) > 0 for run in moving)
    assert all(machine.settling(run) == 0 for run in runs)


def test_a_machine_held_by_dry_friction_is_parked(case):
    _, runs, _ = case
    level = np.array([1.0])
    stuck = Fit(
        hypothesis=Hypothesis(), keys=(("friction.coulomb", "level_left"),), units=("N m",), values=level,
        deviation=level, at_bound=level > 2.0, losses=level, samples=level, rms=1.0, held_out_rms=1.0,
        importance=level, converged=True,
    )  # fmt: skip
    pushed = [replace(run, command=run.command + 0.9) for run in runs]
    assert signals.parked(pushed, stuck)
    assert not signals.parked([replace(run, command=run.command + 9.0) for run in runs], stuck)
    smooth = replace(stuck, keys=(("load.bias", "bias_left"),))
    assert not signals.parked(pushed, smooth)


def test_a_gain_that_is_stated_wrongly_is_no_clock(case):
    """The lag of a position loop is one over its gain: a wrong gain moves the command like a late signal."""
    machine, runs, lsb = case
    for factor in (0.94, 0.7):
        stated = [
            replace(run, controller=run.controller._replace(kp=factor * run.controller.kp))
            for run in runs
        ]
        corrected, findings = examine(machine, stated, lsb)
        assert findings == []
        assert all(a.position is b.position for a, b in zip(corrected, stated))
