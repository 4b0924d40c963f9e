"""Logs of an independent PepperMill-Carrier, and what the instrument makes of them."""

from dataclasses import asdict

import numpy as np
import pytest
import yaml

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.fitting import fit
from gapscope.analysis.gap.hypothesis import Hypothesis
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machine import rms
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.gap.prediction import Predictor
from gapscope.analysis.gap.verdict import NEGLIGIBLE
from gapscope.analysis.pmc import flaw_report, flaws, logs
from gapscope.diagrams.pmc_loop import PMCLoopConfig
from gapscope.diagrams.pmc_rig import measure
from gapscope.models.pmc import simulation


def fitted(folder):
    machine, runs = read_machine(load_logset(folder))
    predictor = Predictor(machine, [run for run in runs if run.use == "fit"])
    return machine, runs, predictor, fit(predictor, Hypothesis())


def test_sound_robot_has_no_gap(tmp_path):
    """Another formulation and integrator, masses within 1 %: nothing is left but the counts.

    A ratio below NEGLIGIBLE is the verdict no_gap, whatever any effect could improve.
    """
    flaws.write("none", tmp_path, seed=3)
    machine, runs, predictor, retuned = fitted(tmp_path)
    residuals = predictor.residuals(retuned.hypothesis, [retuned.values], retuned.keys)[0]
    floor = rms(machine.floor([r for r in runs if r.use == "fit"], residuals)[0])
    assert retuned.held_out_rms < NEGLIGIBLE * floor
    assert {run.use for run in runs} == {"fit", "validate"}


def test_rig_keeps_its_loop_closed():
    config = PMCLoopConfig(controller="ra", speed=4.0)
    log = measure(flaws.rig(flaws.FLAWS["none"], 0), config, 0.05)
    assert log.closure < 1e-8
    assert np.abs(log.command).max() <= config.machine().torque_limit


def test_every_flaw_can_be_built():
    for flaw in flaws.FLAWS.values():
        assert flaws.rig(flaw, 1).robot.pepper_mill_mass > 0.0


@pytest.mark.slow
@pytest.mark.parametrize("name", ["dry-R1", "viscous-L2"])
def test_friction_is_named_where_it_is(name, tmp_path):
    """A corner of another shape is not Stribeck's; friction of one motor is not spread over all."""
    outcome = flaws.trial(name, str(tmp_path), seed=7)
    assert outcome["right"]
    assert outcome["placed"]


def judged(name, verdict, ids, places=(), seed=50):
    effects = [{"id": i, "where": {"elements": list(places)}} for i in ids]
    return asdict(
        flaws.judge(
            name,
            seed,
            {
                "verdict": verdict,
                "effects": effects,
                "ranking": [{"ids": list(ids), "probability": 0.9}],
                "shrinkage": {
                    "before": 1.0, "after": 0.1, "floor": 0.1, "percent": 100.0, "ci95": [99.0, 101.0],
                },
                "provenance": {"seconds": 1.0},
            },
        )
    )  # fmt: skip


def test_report_tells_right_wrong_and_abstaining_apart():
    outcomes = [
        judged("dry-R1", "explained", ("friction.coulomb",), ("R1",)),
        judged("viscous-L2", "explained", ("friction.viscous",), ("L1", "L2")),
        judged("payload", "explained", ("load.bias",)),
        judged("lag", "ambiguous", ("actuator.lag",)),
        judged("weak-R2", "no_gap", ()),
        judged("none", "no_gap", (), seed=51),
    ]
    assert [o["right"] for o in outcomes] == [True, True, False, False, False, True]
    assert [o["wrong"] for o in outcomes] == [False, False, True, False, True, False]
    assert [o["placed"] for o in outcomes[:2]] == [True, False]
    text = flaw_report.markdown(outcomes)
    assert "seeds 50, 51. No log of these seeds was looked at" in text
    assert "right: 3 of 6 (" in text
    assert "confident and wrong: 2 of 6 (" in text
    assert "| explained - wrong | load.bias (0.900) |" in text
    assert "| ambiguous - abstains |" in text
    assert "no proof" in flaw_report.markdown([judged("none", "no_gap", (), seed=4)])


@pytest.fixture
def folder(tmp_path):
    config = PMCLoopConfig(controller="ra")
    machine = config.machine()
    reference = simulation.sample_cycle(config.motion(machine), machine, cycles=0.1)
    run = simulation.run(reference, config.settings(), machine)
    logged = logs.LoggedRun(
        file="run.csv",
        use="fit",
        config=config,
        reference=reference,
        measured=run.measured,
        command=run.command,
    )
    logs.write(tmp_path, "pmc", [logged], machine, reference.joints[0])
    return tmp_path


def test_whole_loop_repeats_the_log(folder):
    """The stated controller on the nominal robot writes the same log again: the same laws, to rounding."""
    machine, (run,) = read_machine(load_logset(folder))
    position, command = machine.simulate(run, machine.build(machine.nominal()).finished())
    # Accelerations of the reference come from the logged angles: resolved acceleration differs a little.
    assert np.abs(position - run.position).max() < 3.0 * run.lsb
    assert rms([command - run.command]) < 0.1 * rms([run.command])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda d: d["system"].pop("home"), r"system\.home: nothing; expected four joints"),
        (lambda d: d["system"].update(homes=1), "unknown key 'homes'"),
        (lambda d: d["system"]["nominal"].update(mass=1.0), "unknown key 'mass'"),
        (lambda d: d["system"]["nominal"].update(payload=-1.0), "payload is -1"),
        (lambda d: d["controller"].update(kind="lqr"), "'lqr'; expected one of ts, pd, ct, ra"),
        (lambda d: d["controller"].update(gain=2.0), "unknown key 'gain'"),
        (lambda d: d["columns"].update(psi_L1="deg"), "the unit is 'deg'"),
        (lambda d: d["system"].update(home=[0.3, 0.3, 2.8, 1.5]), "outside the reach of the limbs"),
    ],
)
def test_unusable_logs_are_refused(folder, change, message):
    path = folder / "logset.yaml"
    document = yaml.safe_load(path.read_text())
    change(document)
    path.write_text(yaml.safe_dump(document))
    with pytest.raises(InputError, match=message):
        read_machine(load_logset(folder))
