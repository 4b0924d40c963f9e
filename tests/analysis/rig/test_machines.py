"""Machines of the toolbox behind the rig: what they log is what the instrument's nominal model says, or a planted fault."""

import numpy as np
import pytest

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.chain_machine import tables
from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.floor import quantisation_floor
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machine import rms
from gapscope.analysis.gap.machines import KINDS, read_machine
from gapscope.analysis.rig import machines
from gapscope.analysis.rig.chain import OVERRUN
from gapscope.analysis.rig.chains import CHAINS
from gapscope.analysis.rig.posture import Posture


def logged(bench, name, plan, fault="none"):
    """A bench after a session, and its log set."""
    b = bench(name, fault=fault, seed=3)
    b.home()
    b.ask("control")
    for motion, rate, cycles, use in plan:
        b.record(motion, rate=rate, cycles=cycles, use=use)
    return b, load_logset(b.rig.recorder.summary()["folder"])


SLOW_TO_BUILD = [pytest.param(name, marks=pytest.mark.slow) for name in ("mast", "3prs")]


@pytest.mark.parametrize("name", ["5r", "replalink", "2prr", "mast", "3prs"])
def test_postures_of_a_chain_are_those_of_its_equations(name):
    """To 1e-4 of the largest term: less than one per cent of the rotors' tolerance of 3 %."""
    chain = CHAINS[name]
    machine = chain.machine(dict(chain.nominal))
    weights = [1.0] + [0.0] * (len(machine.chain.parts()) - 1)
    box = OVERRUN * chain.travel
    posture = Posture(machine.chain, weights, chain.per_motor, chain.home, box)
    joints = box * np.random.default_rng(5).uniform(-1.0, 1.0, (20, len(chain.home)))
    exact = tables(machine.chain, chain.home + joints, chain.per_motor)
    for k, q in enumerate(joints):
        for found, term in zip(posture.at(q / chain.per_motor), exact):
            np.testing.assert_allclose(found, term[k, 0], atol=1e-4 * np.abs(term[:, 0]).max())


def test_a_box_that_the_machine_cannot_fill_is_refused():
    chain = CHAINS["2prr"]
    machine = chain.machine(dict(chain.nominal))
    with pytest.raises(ValueError, match="no posture"):  # further apart than the bars are long
        Posture(machine.chain, [1.0, 0.0], chain.per_motor, chain.home, 0.9)


@pytest.mark.parametrize("name", ["5r", "replalink", "2prr", *SLOW_TO_BUILD])
def test_a_sound_chain_is_predicted_to_the_noise_of_its_encoders(bench, name):
    """Plant and prediction take the machine's terms at the middle of a sample and at its ends: to second order alike."""
    b, log = logged(bench, name, [("opposed", 2.0, 1, "fit")])
    machine, (run,) = read_machine(log)
    floor = quantisation_floor(b.rig.machine.layout.lsb, machine.bandwidth, run.dt)
    plant = machine.build(machine.nominal()).finished()
    assert rms([machine.predict(run, plant)]) == pytest.approx(floor, rel=0.1)
    size = np.ptp(run.reference, axis=0)
    assert np.all(np.abs(run.position - run.reference).max(axis=0) < 0.03 * size)


def test_a_chain_is_mended_in_its_nominal_model_or_not_at_all(bench):
    b = bench("5r")
    b.ask("configure")
    b.ask("set", nominal={"mass5_kg": 0.9, "coulomb_Nm": 0.6}, controller={"kp_Nm_per_rad": 20.0})
    settings = b.rig.machine.settings()
    assert settings["nominal"]["mass5_kg"] == 0.9
    for data in (
        {"nominal": {"mass6_kg": 1.0}},
        {"nominal": {"base_m": -1.0}},
        {"controller": {"kind": "pd"}},
        {"controller": {"kp_Nm_per_rad": -1.0}},
        {"controller": {"gain": 1.0}},
    ):
        with pytest.raises(InputError):
            b.ask("set", **data)
        assert b.rig.machine.settings() == settings


ARM = (("together", 0.2, 2, "fit"), ("fold", 0.25, 2, "fit"), ("wave", 0.3, 2, "fit"),
       ("fold", 0.2, 2, "validate"))  # fmt: skip


@pytest.mark.parametrize("fault", ["friction", pytest.param("none", marks=pytest.mark.slow)])
def test_an_arm_is_diagnosed_from_its_log(bench, fault):
    """The level found is the planted one, to an encoder step; or nothing is found."""
    b, log = logged(bench, "arm", ARM, fault)
    found = diagnose(log).to_json()
    if fault == "none":
        assert found["verdict"] == "no_gap"
        return
    assert [effect["id"] for effect in found["effects"]] == ["friction.coulomb"]
    truth = float(b.rig.machine.answer.split(" of ")[1].split()[0])
    for value in found["effects"][0]["parameters"].values():
        assert value["value"] == pytest.approx(truth, abs=b.rig.machine.layout.lsb)


def test_a_pendulum_is_balanced_by_the_law_that_its_log_states(bench):
    _, log = logged(bench, "furuta", [("short", 1.0, 2, "fit")])
    machine, runs = read_machine(log)
    (check,) = machine.replays(runs)
    assert (
        check.disagreement < 1e-6
    )  # the law, run again on the logged angles, gives the logged voltages
    assert np.abs(log.runs[0].columns["alpha"]).max() < 0.5


def test_moves_of_the_manipulator_add_up_to_its_travel(bench):
    b, log = logged(bench, "mm3a", [("joint 3", 0.004, 1, "fit")])
    columns = log.runs[0].columns
    assert np.all(np.diff(columns["t"]) > 0.0)
    assert log.runs[0].settings["joint"] == 3
    there = columns["q3"] + columns["moved"]
    # What a move is measured to be off by: its scatter, of at most 20 steps.
    np.testing.assert_allclose(there[:-1], columns["q3"][1:], atol=6.0 * 0.003 * 20 * 1e-6)
    with pytest.raises(InputError, match="at most"):
        b.ask("load", name="joint 3", rate_Hz=0.1, cycles=1)
    with pytest.raises(InputError, match="a table"):
        b.ask("load", csv="t,joint 1,joint 2,joint 3\n")


def test_every_kind_of_log_set_has_a_machine_on_the_rig():
    """Kinds are those of the instrument; the one of model files is any file."""
    parallel = {chain.kind for chain in CHAINS.values()}
    single = {machines.build(name, "none", 1).layout.kind for name in machines.OTHERS}
    assert {*parallel, *single, "model_file"} == set(KINDS)


@pytest.mark.parametrize("name", machines.NAMES)
def test_every_machine_keeps_what_is_wrong_with_it_to_itself(name):
    if name in ("mast", "3prs"):
        pytest.skip("built alike; takes seconds")
    machine = machines.build(name, "mystery", 1)
    assert machine.answer not in str(machine.document())
    assert "answer" not in machine.document()
    with pytest.raises(InputError, match="unknown fault"):
        machines.build(name, "gremlins", 1)


def test_an_unknown_machine_is_one_error():
    with pytest.raises(InputError, match="one of c-drive"):
        machines.build("hexapod", "none", 1)


CHAIN = (("together", 1.0, 2, "fit"), ("opposed", 1.5, 2, "fit"), ("single", 1.25, 2, "fit"),
         ("together", 1.25, 2, "validate"))  # fmt: skip
SWEEPS = (("short", 1.0, 5, "fit"), ("medium", 0.5, 3, "fit"), ("long", 0.4, 3, "fit"),
          ("medium", 0.4, 3, "validate"))  # fmt: skip
MOVES = (
    *((name, 0.004, 1, "fit") for name in ("joint 3", "joint 3 raised", "joint 3 lowered")),
    *((name, 0.004, 1, "fit") for name in ("joint 2 up", "joint 2 down")),
    *((name, 0.003, 1, "validate") for name in ("joint 3 raised", "joint 2 up", "joint 2 down")),
)
SWINGS = (("short", 0.5, 3, "fit"), ("long", 0.4, 3, "fit"), ("back", 0.6, 3, "fit"),
          ("long", 0.5, 3, "validate"))  # fmt: skip
STROKES = (("short", 0.5, 3, "fit"), ("long", 0.5, 3, "fit"), ("medium", 1.0, 3, "fit"),
           ("long", 0.8, 3, "validate"))  # fmt: skip
PLANS = {"furuta": SWEEPS, "mm3a": MOVES, "arm": ARM, "pendulum": SWINGS, "piezo": STROKES}
SESSIONS = (
    ("5r", "payload", "inertia.payload"),
    ("2prr", "payload", "inertia.payload"),
    ("mast", "none", None),
    ("3prs", "payload", "inertia.payload"),
    ("replalink", "none", None),
    ("mm3a", "load", "step.load"),
    ("mm3a", "none", None),
    ("furuta", "payload", "inertia.payload"),
    ("furuta", "none", None),
    ("arm", "weight", "load.bias"),
    ("pendulum", "friction", "friction.coulomb"),
    ("pendulum", "gear", "friction.load_dependent"),
    ("pendulum", "none", None),
    ("piezo", "hysteresis", "actuator.hysteresis"),
    ("piezo", "lag", "actuator.lag"),
    ("piezo", "none", None),
)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "fault", "effect"), SESSIONS)
def test_a_session_on_any_machine_ends_with_its_fault_named(bench, name, fault, effect):
    _, log = logged(bench, name, PLANS.get(name, CHAIN), fault)
    found = diagnose(log).to_json()
    assert found["verdict"] == ("no_gap" if effect is None else "explained")
    assert [e["id"] for e in found["effects"]] == ([] if effect is None else [effect])
