"""Closed chains in the instrument, on logs of machines that share no code with it."""

import json

import numpy as np
import pytest
import yaml
from typer.testing import CliRunner

from gapscope.analysis.cli import app
from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.chain_machine import tables
from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.floor import quantisation_floor
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machine import rms
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import Predictor
from gapscope.models.parallel.machine import FiveBarMachine, TableMachine, TwoPRRMachine
from gapscope.models.parallel.three_prs import FLEXURES, THREE_PRS

from . import closed_chain_machine, mast_machine
from .closed_chain_machine import replalink_rig, three_prs_rig, two_prr_rig
from .five_bar_machine import Truth, write_log_set

SEED = 0


def test_prediction_error_of_a_right_model_is_the_encoders_noise(tmp_path):
    machine, runs = read_machine(load_logset(write_log_set(tmp_path / "log", Truth(), SEED)))
    plant = machine.build(machine.nominal()).finished()
    for run in runs:
        floor = quantisation_floor(run.lsb, machine.bandwidth, run.dt)
        assert rms([machine.predict(run, plant)]) == pytest.approx(floor, rel=0.03)


@pytest.mark.slow
def test_five_bar_as_described_has_no_gap(tmp_path):
    assert diagnose(write_log_set(tmp_path / "log", Truth(), SEED)).verdict.verdict == "no_gap"


def fitted(folder, *wanted):
    """The hypothesis of these (effect, form) fitted, beside the retuned nominal model."""
    machine, runs = read_machine(load_logset(folder))
    predictor = Predictor(machine, [run for run in runs if run.use == "fit"])
    forms = tuple(f for f in machine.forms(runs) if (f.effect, f.name) in wanted)
    assert len(forms) == len(wanted)
    retuned = fit(predictor, Hypothesis())
    return retuned, fit(predictor, Hypothesis(forms=forms), retuned)


PAYLOAD = ("inertia.payload", "added inertia")
COULOMB = ("friction.coulomb", "smoothed sign")


def test_a_heavier_tool_is_measured(tmp_path):
    """0.4 kg more at the tool than described, and the rotors as they are."""
    retuned, found = fitted(write_log_set(tmp_path / "log", Truth(tool_mass=0.9), SEED), PAYLOAD)
    values = found.by_key()
    assert values[("inertia.payload", "extra_tool")] == pytest.approx(0.4, abs=0.002)
    assert values[("inertia.payload", "extra_rotors")] == pytest.approx(0.0, abs=2e-6)
    assert found.rms < 0.1 * retuned.rms


def test_identified_table_told_from_the_manufacturers(tmp_path):
    """Section 4.2.4.2: J_1 / 1.56 and 7.18e-2 N m of Coulomb friction, where data sheets say otherwise."""
    log = mast_machine.write_log_set(tmp_path / "log")
    retuned, found = fitted(log, PAYLOAD, COULOMB)
    values = found.by_key()
    less = mast_machine.DRIVING * (1.0 / 1.56 - 1.0)
    assert values[("inertia.payload", "extra_rotors")] == pytest.approx(less, rel=0.03)
    for i in (1, 2, 3):
        level = values[("friction.coulomb", f"level_slider{i}")]
        assert level == pytest.approx(7.18e-2 - 1.949e-2, rel=0.03)
    assert found.rms < 0.3 * retuned.rms


@pytest.mark.slow
def test_diagnosis_of_the_five_bar(tmp_path):
    found = diagnose(write_log_set(tmp_path / "log", Truth(tool_mass=0.9), SEED)).to_json()
    assert found["verdict"] == "explained"
    named = [(e["id"], e["where"]) for e in found["effects"]]
    assert named == [("inertia.payload", {"axes": ["tool"]})]
    assert found["shrinkage"]["percent"] > 99.0


@pytest.mark.parametrize("rig", [two_prr_rig(), replalink_rig(), three_prs_rig()])
def test_prediction_error_on_a_multibody_tree_is_the_encoders_noise(tmp_path, rig):
    """Within the second order of a sample that both sides leave: 6 % of the noise in the 2-PRR's faster run."""
    log = closed_chain_machine.write_log_set(tmp_path / "log", rig, samples=400)
    machine, runs = read_machine(load_logset(log))
    plant = machine.build(machine.nominal()).finished()
    for run in runs:
        floor = quantisation_floor(run.lsb, machine.bandwidth, run.dt)
        assert rms([machine.predict(run, plant)]) == pytest.approx(floor, rel=0.1)


CLOSED_CHAINS = [
    (two_prr_rig(), None, ""),
    (two_prr_rig(payload=0.6), "inertia.payload", "platform"),
    (three_prs_rig(), None, ""),
    (three_prs_rig(payload=0.15), "inertia.payload", "platform"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("rig", "effect", "place"), CLOSED_CHAINS)
def test_diagnosis_of_a_multibody_tree(tmp_path, rig, effect, place):
    """What is withheld is named, and its place; as described there is no gap."""
    found = diagnose(closed_chain_machine.write_log_set(tmp_path / "log", rig)).to_json()
    if effect is None:
        assert found["verdict"] == "no_gap"
        return
    assert found["verdict"] == "explained"
    assert [e["id"] for e in found["effects"]] == [effect]
    assert any(place in names for names in found["effects"][0]["where"].values())
    assert found["shrinkage"]["percent"] > 95.0


def five_bar_log(folder):
    return write_log_set(folder, Truth(coulomb=(0.478, 0.7)), SEED)


def chain_log(rig):
    return lambda folder: closed_chain_machine.write_log_set(folder, rig)


PLANTED = {
    "five_bar": (five_bar_log, "crank4"),
    "two_prr": (chain_log(two_prr_rig(coulomb=(0.035, 0.055))), "slider2"),
    "replalink": (chain_log(replalink_rig(coulomb=(0.0551, 0.12))), "crank4"),
    "mast": (mast_machine.write_log_set, "slider"),
    "three_prs": (chain_log(three_prs_rig(coulomb=(0.004, 0.007, 0.004))), "slider2"),
}


@pytest.mark.slow
@pytest.mark.parametrize("kind", PLANTED)
def test_command_finds_the_planted_friction(tmp_path, kind):
    """``gapscope diagnose`` on a log set of each kind."""
    write, place = PLANTED[kind]
    log = write(tmp_path / "log")
    done = CliRunner().invoke(app, ["diagnose", str(log), "--out", str(tmp_path / "out")])
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert found["verdict"] == "explained"
    (friction,) = [e for e in found["effects"] if e["id"] == "friction.coulomb"]
    assert any(place in name for names in friction["where"].values() for name in names)
    others = {e["id"] for e in found["effects"]} - {"friction.coulomb"}
    assert others == ({"inertia.payload"} if kind == "mast" else set())
    assert found["shrinkage"]["percent"] > 90.0


COMPLIANT = TableMachine(table=THREE_PRS, flexures=FLEXURES)


@pytest.mark.parametrize("machine", [FiveBarMachine(), TwoPRRMachine(), TableMachine(), COMPLIANT])
def test_tables_hold_the_machine_s_equations(machine):
    """Torque of the tables at any rates and accelerations is that of the inverse dynamics, times i_R."""
    rng = np.random.default_rng(71)
    n = len(machine.joints)
    homes = {FiveBarMachine: [1.9, 1.1], TwoPRRMachine: [0.2, 0.25], TableMachine: [0.0, 0.0, 0.0]}
    reach = 0.001 if machine is COMPLIANT else 0.05
    q = np.array(homes[type(machine)]) + reach * rng.normal(size=(6, n))
    rate, acceleration, per = rng.normal(size=n), rng.normal(size=n), 0.02
    terms = tables(machine, q, per)
    for p, part in enumerate(machine.parts().values()):
        for k in range(len(q)):
            torque = terms.inertia[k, p] @ acceleration + terms.gravity[k, p]
            torque = torque + np.einsum("ijk,j,k->i", terms.velocity[k, p], rate, rate)
            force = part.equations(q[k], per * rate).force(per * acceleration)
            assert torque == pytest.approx(per * force, rel=1e-9, abs=1e-12)


def bad_log_set(folder, change):
    folder.mkdir()
    t = 1e-3 * np.arange(200)
    columns = np.column_stack([t, *[0 * t + 2.0, 0 * t + 1.0] * 2, 0 * t, 0 * t])
    np.savetxt(
        folder / "run1.csv", columns, delimiter=",", comments="",
        header="t,q1_ref,q2_ref,q1,q2,current1,current2",
    )  # fmt: skip
    units = {f"q{i}{end}": "rad" for i in (1, 2) for end in ("", "_ref")}
    document = {
        "format": 1, "name": "bad",
        "system": {"kind": "five_bar", "nominal": {
            "gear_ratio": 40.0, "torque_constant_Nm_per_A": 1.43, "rotor_inertia_kg_m2": 1e-3,
            "viscous_Nms_per_rad": 1e-3,
        }},
        "controllers": {"pd": {"kind": "not stated"}}, "sample_time_s": 1e-3,
        "columns": {"t": "s", **units, "current1": "A", "current2": "A"},
        "runs": [{"file": "run1.csv", "use": "fit", "controller": "pd"}],
    }  # fmt: skip
    change(document)
    (folder / "logset.yaml").write_text(yaml.safe_dump(document))
    return folder


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d["system"]["nominal"].pop("rotor_inertia_kg_m2"), "rotor_inertia_kg_m2"),
        (
            lambda d: d["system"]["nominal"].update(base_m=-1.0),
            r"base_m: -1\.0; expected a positive",
        ),
        (lambda d: d["system"]["nominal"].update(crank_m=1.0), "unknown key 'crank_m'"),
        (lambda d: d["columns"].update(q1="deg"), "the unit is 'deg'"),
        (lambda d: d["system"]["nominal"].update(rod3_m=0.05), "row 2"),
    ],
)
def test_unusable_input_is_one_error(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        read_machine(load_logset(bad_log_set(tmp_path / "log", change)))
