"""Log sets of moves (``kind: mm3a``): planted effects by the empirical law, floors, and wrong input.

The law that moves the arm here is the one hypotheses use, so these tests show that the machinery works,
not that it finds real effects: ``test_mm3a_blind.py`` has the physical actuator as truth.
"""

import json
from dataclasses import replace

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from gapscope.analysis import cli
from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.slip_terms import SlipTerms, step_change
from gapscope.analysis.gap.step_effects import catalogue
from gapscope.analysis.gap.step_machine import LAW_MISFIT, mean_step, move, repeats
from gapscope.analysis.mm3a import empirical_moves
from gapscope.analysis.mm3a.moves import HALF, Series, diagnosis_plan, perform, write_logset
from gapscope.models import chang_li
from gapscope.models.mm3a import stepper
from gapscope.models.mm3a.arm import STANDARD_GRAVITY, Arm, gravity_in_base
from gapscope.models.mm3a.step_size import StepModel

RUNNER = CliRunner()
SCATTER = 0.003


def write(folder, *effects, plan=None, seed=0, scatter=SCATTER, nominal=None):
    """A log set moved by the empirical law with ``effects``."""
    planted = empirical_moves.plant(*effects)
    plan = diagnosis_plan(run_in=8, sessions=("day-1",)) if plan is None else plan
    tables = perform(plan, empirical_moves.EmpiricalMover(planted), scatter=scatter, seed=seed)
    write_logset(folder, plan, tables, nominal or planted.nominal())
    return folder


def accepted(diagnosis):
    return {e["id"]: e for e in diagnosis.to_json()["effects"]}


def value(effect, name):
    return effect["parameters"][name]["value"]


@pytest.mark.parametrize("seed", range(4))
def test_nothing_planted_nothing_found(tmp_path, seed):
    diagnosis = diagnose(write(tmp_path, seed=seed))
    assert diagnosis.verdict.verdict == "no_gap"
    # 240 moves: the scatter within its own statistical error, and what the law may be off.
    assert np.sqrt(diagnosis.floor**2 - LAW_MISFIT**2) == pytest.approx(SCATTER, rel=0.2)


# Intervals of the parameters are 95 %; a planted value may lie outside one now and then, so the
# tolerance is three times what the scatter leaves of each over this plan.
@pytest.mark.parametrize(
    ("effect", "expected", "tolerance"),
    [
        ("step.load", {"load_3_negative": -436e-9, "load_3_positive": 375.55e-9}, 8e-9),
        ("step.recoil", {"recoil_negative": 0.25, "recoil_positive": 0.27}, 5e-3),
        ("step.direction", {"asymmetry_2": 0.08, "asymmetry_3": 0.08}, 2e-3),
        ("step.drift", {"day2_2": 0.06, "day2_3": 0.06}, 3e-3),
        ("step.drift:warming", {"warming_2": 0.05, "warming_3": 0.05}, 6e-3),
        ("inertia.payload", {"mass": 0.5e-3}, 2e-5),
    ],
)
def test_planted_effect_is_named_and_its_size_recovered(tmp_path, effect, expected, tolerance):
    # One day of 240 moves leaves a payload and free load terms, or a warming, too little apart.
    short = effect in ("step.load", "step.recoil", "step.direction")
    diagnosis = diagnose(write(tmp_path, effect, plan=None if short else diagnosis_plan()))
    assert diagnosis.verdict.verdict == "explained"
    found = accepted(diagnosis)
    assert list(found) == [effect.partition(":")[0]]
    for name, true in expected.items():
        assert value(found[effect.partition(":")[0]], name) == pytest.approx(true, abs=tolerance)
    assert diagnosis.shrinkage.percent > 95.0


def test_direction_memory_is_named_where_moves_reverse_without_run_in(tmp_path):
    diagnosis = diagnose(
        write(tmp_path, "actuator.hysteresis", plan=diagnosis_plan(sessions=("day-1",)))
    )
    assert diagnosis.verdict.verdict == "explained"
    found = accepted(diagnosis)
    assert list(found) == ["actuator.hysteresis"]
    for name in ("gain_2", "gain_3"):
        assert value(found["actuator.hysteresis"], name) == pytest.approx(-0.9, abs=0.05)


def test_two_effects_are_both_named(tmp_path):
    diagnosis = diagnose(write(tmp_path, "step.direction", "inertia.payload"))
    assert set(accepted(diagnosis)) == {"step.direction", "inertia.payload"}


def test_one_session_alike_everywhere_cannot_tell_the_day_from_the_scale(tmp_path):
    """One joint, one day: a step and a reading that are off by the same share are the same data."""
    plan = [
        s for s in diagnosis_plan(run_in=8, sessions=("only",)) if s.joint == 3 and s.theta == HALF
    ]
    plan += [replace(plan[0], use="validate")]
    stated = empirical_moves.plant().nominal()
    for name in ("joint_3_negative", "joint_3_positive"):
        stated[name] = {**stated[name], "basic": 0.9 * stated[name]["basic"]}
    diagnosis = diagnose(write(tmp_path, plan=plan, nominal=stated))
    assert diagnosis.verdict.verdict == "ambiguous"
    assert {"step.drift", "sensor.scale"} <= set(accepted(diagnosis))


def test_a_stop_that_no_hypothesis_knows_is_not_explained(tmp_path):
    """Every seventh move loses a third: no effect of the catalogue does that."""
    plan = diagnosis_plan(run_in=8, sessions=("day-1",))
    planted = empirical_moves.plant()
    tables = perform(plan, empirical_moves.EmpiricalMover(planted), scatter=SCATTER, seed=0)
    for table in tables:
        table[::7, -1] *= 0.67
    write_logset(tmp_path, plan, tables, planted.nominal())
    diagnosis = diagnose(tmp_path)
    assert diagnosis.verdict.verdict == "unexplained"
    assert not accepted(diagnosis)


def machine_of(folder):
    return read_machine(load_logset(folder))


def test_prediction_is_the_stepper_step_by_step(tmp_path):
    """Mean step times steps, against the sum of single steps of the stepper's law: (1), (2)."""
    plan = [
        Series(joint=j, theta=-0.4, postures=((0.3, -1.1, 0.004),), session="a", counts=(300,))
        for j in (1, 2, 3)
    ]
    planted = empirical_moves.plant()
    model = StepModel()
    nominal = {
        **planted.nominal(),
        **{f"joint_1_{s}": vars(getattr(model, f"joint_1_{s}")) for s in ("negative", "positive")},
        "repeatability": 0.01,
    }
    plan = [replace(s, repeats=3) for s in plan]
    tables = perform(plan, empirical_moves.EmpiricalMover(planted), scatter=0.0, seed=0)
    write_logset(tmp_path, plan, tables, nominal)
    machine, runs = machine_of(tmp_path)
    for run in runs:
        # 300 steps are 27 mrad: five Gauss points leave less than 1e-6, half a step's shift of where
        # each is evaluated leaves up to 1e-4 of the change along the move.
        assert np.max(np.abs(machine.predict(run, machine.build(machine.nominal())))) < 2e-4


def test_a_mass_on_the_tip_is_a_force_in_the_stepper(tmp_path):
    planted = empirical_moves.plant()
    machine, runs = machine_of(write(tmp_path))
    plant = machine.build(machine.nominal())
    plant.payload = 0.7e-3
    for run in (runs[0], runs[1]):
        theta = run.settings["theta_rad"]
        gravity = np.array(gravity_in_base(theta, 0.0))
        q = np.array([0.0, run.elbow[0, 2], 0.012 * run.extension[0, 2]])
        session = (
            stepper.Conditions(theta=theta).session()._replace(force=tuple(plant.payload * gravity))
        )
        expected = stepper.coarse_motion(
            run.joint, 1, q, np.zeros(3), np.zeros(3), planted.true.table(), session, Arm()
        )
        assert mean_step(run, plant)[0] == pytest.approx(expected, rel=1e-5)


def test_repeats_are_like_moves_only(tmp_path):
    _, runs = machine_of(write(tmp_path))
    run = runs[0]  # 5 postures, moves of 10 and 30 steps, ++-- each: one pair per direction
    residual = np.arange(len(run.t), dtype=float)[:, None]
    np.testing.assert_allclose(repeats(run, residual), np.full((20, 1), 1 / np.sqrt(2.0)))


def test_reversal_is_seen_only_without_run_in(tmp_path):
    _, with_run_in = machine_of(write(tmp_path / "a"))
    _, without = machine_of(write(tmp_path / "b", plan=diagnosis_plan(sessions=("day-1",))))
    assert not any(run.reverses.any() for run in with_run_in)
    assert without[0].reverses[:4].tolist() == [False, False, True, False]
    plant_machine = machine_of(tmp_path / "b")[0]
    plant = plant_machine.build(plant_machine.nominal())
    plain = move(without[0], plant)
    plant.reversal[2] = 2.0
    np.testing.assert_allclose(move(without[0], plant)[2] / plain[2], 1.2, rtol=1e-12)


def test_first_move_of_a_run_reverses_the_last_one_of_its_joint_in_the_session(tmp_path):
    """Moves of a repeat are ++--, so every run but the first of a joint in a session begins with a reversal."""
    plan = diagnosis_plan(sessions=("day-1", "day-2"))
    _, runs = machine_of(write(tmp_path, plan=plan))
    begun = [(run.session, run.joint) for run in runs]
    first = [key not in begun[:i] for i, key in enumerate(begun)]
    assert [bool(run.reverses[0]) for run in runs] == [not is_first for is_first in first]


STROKE, FLYBACK, FRICTION = 2.4e-6, 1e-4, 0.1  # of a slider by Chang and Li


def slider_step(mass, load):
    return chang_li.step(STROKE, FLYBACK, FRICTION, mass, load)


@pytest.mark.parametrize("theta", [0.0, HALF])
def test_heavier_tip_changes_steps_as_chang_and_li_s_slider(tmp_path, theta):
    """Against the closed form with all its constants: the step of a heavier slider less that of the stated one."""
    arm, more = Arm(), 0.6e-3
    _, runs = machine_of(write(tmp_path))
    run = next(r for r in runs if r.joint == 2 and r.settings["theta_rad"] == pytest.approx(theta))
    weight = arm.mass_3 * STANDARD_GRAVITY
    terms = SlipTerms(mass=more)
    terms.fallback[2] = FLYBACK**2 * FRICTION / arm.mass_3
    terms.grip[2] = FRICTION / weight
    found = step_change(run, terms, 1.0)
    signed = np.where(run.side == 1, 1.0, -1.0)
    for i in range(len(run.t)):
        load = signed[i] * run.load[i, 2] * weight
        heavy = slider_step(arm.mass_3 + more, load * (1.0 + more / arm.mass_3))
        assert found[i, 2] == pytest.approx(heavy - slider_step(arm.mass_3, load), rel=1e-9)


def test_other_flybacks_by_direction_lose_as_chang_and_li_s_slider(tmp_path):
    machine, runs = machine_of(write(tmp_path))
    (form,) = (f for f in machine.forms(runs) if f.name == "flyback")
    run = next(r for r in runs if r.joint == 2)
    weight, difference = Arm().mass_3 * STANDARD_GRAVITY, 0.1
    lost = FLYBACK**2 * FRICTION / Arm().mass_3
    plant = machine.build(machine.nominal())
    values = {p.name: p.starts[0] for p in form.parameters}
    values |= {"flyback_3": difference * lost, "fallback_3": lost, "grip_3": FRICTION / weight}
    form.apply(plant, values)
    found = step_change(run, plant.slip, 1.0)
    for i, side in enumerate(run.side):
        signed = 1.0 if side == 1 else -1.0
        load, time = signed * run.load[i, 2] * weight, FLYBACK * (1.0 - 0.5 * signed * difference)
        other = chang_li.step(STROKE, time, FRICTION, Arm().mass_3, load)
        assert found[i, 2] == pytest.approx(other - slider_step(Arm().mass_3, load), rel=1e-9)


def test_a_frame_in_series_with_the_stack_takes_its_share_of_the_stroke(tmp_path):
    _, runs = machine_of(write(tmp_path))
    run, share = next(r for r in runs if r.joint == 2), 0.3
    terms = SlipTerms(frame=STROKE * share / (1.0 + share), compliance=share)
    expected = STROKE / (1.0 + share * np.cos(run.elbow) ** 2) - STROKE
    np.testing.assert_allclose(step_change(run, terms, 1.0), expected, rtol=1e-12, atol=1e-24)


def test_what_a_contact_makes_of_a_payload_is_nothing_without_its_mass(tmp_path):
    machine, runs = machine_of(write(tmp_path))
    (form,) = (f for f in machine.forms(runs) if f.name == "slider")
    plant = machine.build(machine.nominal())
    form.apply(plant, {p.name: p.starts[0] or p.scale for p in form.parameters} | {"mass": 0.0})
    for run in runs:
        assert not np.any(step_change(run, plant.slip, 1.0))


def test_the_law_s_own_error_can_be_stated(tmp_path):
    folder = write(tmp_path, plan=diagnosis_plan(run_in=8, sessions=("a",)))
    exact = machine_of(folder)[0]
    _edit(lambda d: d["system"]["nominal"].update(law_error=0.02))(folder)
    coarse, runs = machine_of(folder)
    residuals = [coarse.predict(run, coarse.build(coarse.nominal())) for run in runs]
    assert (exact.law_error.law, coarse.law_error.law) == (LAW_MISFIT, 0.02)
    floor = np.concatenate(coarse.floor(runs, residuals)[0])
    own = np.concatenate(coarse.repeatability_of(runs, residuals)[0])
    np.testing.assert_allclose(floor**2, own**2 + 0.02**2, rtol=1e-12)
    assert "2 % that the step law" in coarse.floor(runs, residuals)[1]


def test_steps_without_length_are_a_failed_hypothesis_not_a_crash(tmp_path):
    machine, runs = machine_of(write(tmp_path))
    plant = machine.build(machine.nominal())
    plant.table[2, :, 2] = 5e-6
    assert np.isnan(machine.predict(runs[0], plant)).any()


def test_location_shares_sum_to_one(tmp_path):
    location = diagnose(write(tmp_path, "step.recoil")).location
    for key in ("signals", "joints", "regimes", "bands"):
        assert sum(row["share"] for row in location[key]) == pytest.approx(1.0)
    joints = {row["name"]: row["share"] for row in location["joints"]}
    assert joints["joint_3"] > 0.95  # the gap is that joint's


def test_catalogue_holds_the_step_effects():
    expected = {
        "step.load", "step.recoil", "step.direction", "step.drift", "inertia.payload",
        "actuator.hysteresis", "sensor.scale",
    }  # fmt: skip
    assert set(catalogue()) == expected


def _edit(change):
    def edit(folder):
        path = folder / "logset.yaml"
        document = yaml.safe_load(path.read_text())
        change(document)
        path.write_text(yaml.safe_dump(document))

    return edit


def _row(column, text):
    def edit(folder):
        path = folder / "run1.csv"
        lines = path.read_text().splitlines()
        cells = lines[3].split(",")
        cells[lines[0].split(",").index(column)] = text
        lines[3] = ",".join(cells)
        path.write_text("\n".join(lines) + "\n")

    return edit


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (_row("steps", "0"), r"row 4, column steps: 0; expected a whole number of steps"),
        (_row("steps", "2.5"), r"column steps: 2\.5"),
        (_row("moved", "0"), r"row 4, column moved: 0; expected a displacement in the dir"),
        (_edit(lambda d: d["runs"][0].pop("joint")), r"runs\[run1\.csv\]\.joint: nothing; expected 1, 2 or 3"),
        (_edit(lambda d: d["runs"][0].update(q=1)), r"unknown key 'q'"),
        (_edit(lambda d: d["runs"][0].update(force_N=3)), r"force_N: 3; expected a list of 3 numbers"),
        (
            _edit(lambda d: d["system"]["nominal"].pop("joint_3_positive")),
            r"joint_3_positive is None, but that joint moves",
        ),
        (
            _edit(lambda d: d["system"]["nominal"]["joint_3_positive"].update(basic=-1.0)),
            r"basic steps are \[-1\.0\]; expected positive",
        ),
        (_edit(lambda d: d["columns"].update(moved="m")), r"the unit is 'm'; expected rad or m"),
        (_edit(lambda d: d.update(resample="linear")), r"resample is stated for moves"),
        (
            _edit(lambda d: d["system"]["nominal"].update(law_error=-0.1)),
            r"nominal\.law_error: -0\.1; expected the relative rms",
        ),
        (
            _edit(lambda d: d["system"]["nominal"].update(arm={"mass_3": -1.0})),
            r"nominal\.arm: arm: mass_3 is -1\.0; expected a positive",
        ),
    ],
)  # fmt: skip
def test_unusable_input_is_one_error(tmp_path, spoil, message):
    folder = write(tmp_path, plan=diagnosis_plan(run_in=8, sessions=("a",))[:2])
    spoil(folder)
    with pytest.raises(InputError, match=message):
        machine_of(folder)


def test_no_repeats_and_no_stated_repeatability_is_refused(tmp_path):
    plan = [
        Series(
            joint=3, theta=0.0, session="a", run_in=8, counts=(10, 20, 30, 40), repeats=1,
            postures=((0.0, -1.5, 0.002), (0.0, -1.2, 0.004), (0.0, -1.0, 0.006)),
        )
    ]  # fmt: skip
    folder = write(tmp_path, plan=plan)
    text = (folder / "run1.csv").read_text().splitlines()
    (folder / "run1.csv").write_text("\n".join([text[0], *text[1::2]]) + "\n")  # one of each pair
    with pytest.raises(InputError, match="0 moves repeat another"):
        machine_of(folder)
    _edit(lambda d: d["system"]["nominal"].update(repeatability=0.004))(folder)
    assert machine_of(folder)[0].repeatability == 0.004


def test_simulate_then_diagnose_on_the_command_line(tmp_path):
    logs, out = tmp_path / "logs", tmp_path / "out"
    made = RUNNER.invoke(
        cli.app, ["simulate", "mm3a", "--moves", "--effect", "step.direction", "--out", str(logs)]
    )
    assert made.exit_code == 0, made.output
    found = RUNNER.invoke(cli.app, ["diagnose", str(logs), "--out", str(out)])
    assert found.exit_code == 0, found.output
    result = json.loads((out / "diagnosis.json").read_text())
    assert [e["id"] for e in result["effects"]] == ["step.direction"]
    assert "design" not in result["next_experiment"]
    assert (out / "report.html").exists() or list(out.glob("*.html"))


def test_unknown_effects_and_truths_are_refused(tmp_path):
    for arguments, message in (
        (["--moves", "--effect", "step.magic"], "unknown effect 'step.magic'"),
        (["--moves", "--truth", "wishful"], "unknown truth"),
        (["--effect", "step.load"], "there are no moves to put it in"),
    ):
        result = RUNNER.invoke(
            cli.app, ["simulate", "mm3a", "--out", str(tmp_path / "x"), *arguments]
        )
        assert isinstance(result.exception, InputError)
        assert message in str(result.exception)
