"""Cases with the physical actuator as truth: what they are made of, and an open one diagnosed."""

from collections import Counter

import numpy as np
import pytest

from gapscope.analysis.gap.diagnosis import diagnose
from gapscope.analysis.gap.step_machine import LAW_MISFIT
from gapscope.analysis.mm3a import blind
from gapscope.analysis.mm3a.moves import Series, diagnosis_plan, perform
from gapscope.analysis.mm3a.physical_moves import PhysicalMover, Truth
from gapscope.models.mm3a import dynamics
from gapscope.models.mm3a.arm import Arm, gravity_in_base


def test_a_deck_holds_every_kind_and_draws_again_alike():
    cases = [blind.draw(3, i) for i in range(len(blind.DECK))]
    kinds = Counter(case.kind for case in cases)
    assert kinds == {"none": 4, "single": 18, "off_library": 4, "double": 4}
    singles = Counter(case.answer[0] for case in cases if case.kind == "single")
    assert singles == dict.fromkeys(blind.SINGLE, 3)
    again = blind.draw(3, 7)
    assert (again.answer, again.parameters) == (cases[7].answer, cases[7].parameters)


def test_loads_of_the_plant_are_those_of_the_thesis_with_the_payload_as_a_force():
    """The hypotheses' closed form and the generator's Drake plant, which share no code, agree."""
    mover, mass = PhysicalMover(Truth(payload=0.8e-3)), 0.8e-3
    q, theta = np.array([0.4, -1.1, 0.005]), -0.6
    gravity = np.array(gravity_in_base(theta, 0.0))
    expected = dynamics.static_load(q, gravity, mass * gravity, Arm())
    for joint in range(3):
        load, inertia = mover.load_and_inertia(joint, q, theta)
        assert load == pytest.approx(expected[joint], rel=1e-12)
        assert inertia > dynamics.mass_diagonal(q, Arm())[joint]


def test_recoil_of_the_frame_shortens_a_step():
    q = np.array([0.0, -0.5, 0.006])
    up = Series(joint=3, theta=0.0, postures=(tuple(q),), session="a", run_in=6)
    moved = {}
    for name, truth in (
        ("sound", Truth()),
        ("frame", Truth(frame=0.2)),
    ):
        mover = PhysicalMover(truth)
        mover.begin("a")
        moved[name] = mover.move(up, q, 6, 0.0)
    assert moved["frame"] < 0.9 * moved["sound"]


@pytest.mark.slow
@pytest.mark.parametrize("hysteresis", ["bouc_wen", "maxwell", "none"])
def test_a_calibrated_law_misses_the_physical_actuator_by_no_more_than_the_floor_allows(hysteresis):
    truth = Truth(hysteresis=hysteresis)
    plan = diagnosis_plan(blind.RUN_IN, sessions=("calibration",))
    exact = perform(plan, PhysicalMover(truth), scatter=0.0, seed=0)
    misses = blind.Statement(plan, exact, PhysicalMover(truth)).misses(plan, exact)
    assert 0.25 * LAW_MISFIT < misses < LAW_MISFIT


def test_a_physical_recoil_is_named(tmp_path):
    """An open case, seed 0: a frame in series with the stack takes stroke, whatever the load leaves of a step."""
    diagnosis = opened(tmp_path, "step.recoil")
    assert diagnosis["verdict"] == "explained"
    assert [e["id"] for e in diagnosis["effects"]] == ["step.recoil"]


@pytest.mark.slow
@pytest.mark.parametrize("effect", [e for e in blind.SINGLE if e != "step.recoil"])
def test_a_physical_effect_is_named(tmp_path, effect):
    """Open cases, seed 0, one each: they show that the forms fit physics, not how often."""
    diagnosis = opened(tmp_path, effect)
    assert diagnosis["verdict"] == "explained"
    assert [e["id"] for e in diagnosis["effects"]] == [effect]


def opened(folder, effect):
    blind.write_moves(blind.drawn((effect,), 0), 0, folder)
    return diagnose(folder).to_json()
