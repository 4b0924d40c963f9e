"""Cases are decided by the seed, complete, and say nothing of their answer."""

import numpy as np
import pytest
import yaml

from gapscope.analysis.blind_machine import (
    cases,
    drive_logset,
    slider_effects,
    strength,
    write_case,
)
from gapscope.analysis.blind_machine.c_drive import Machine
from gapscope.analysis.blind_machine.drive_effects import EFFECTS
from gapscope.analysis.blind_machine.motion import AMPLITUDE, out_and_back
from gapscope.analysis.blind_machine.off_library import OFF_LIBRARY
from gapscope.analysis.blind_machine.slider import Slider


def index_of(seed, kind, machine=Machine):
    """First case of a kind on a machine in a seed's first deck."""
    deck = cases._deck(np.random.default_rng([seed, 0, 0]))
    indices = [i for i, (k, _) in enumerate(deck) if k == kind]
    return next(i for i in indices if isinstance(cases.draw(seed, i).nominal, machine))


def test_a_deck_holds_every_mechanism_once_and_ten_without_effect():
    deck = cases._deck(np.random.default_rng([5, 0, 0]))
    singles = sorted(causes[0] for kind, causes in deck if kind == "single")
    assert singles == sorted(EFFECTS)
    assert len(deck) == cases.DECK == 40
    assert sum(kind == "none" for kind, _ in deck) == 10
    assert sum(kind == "double" for kind, _ in deck) == 6
    assert {c for kind, (*causes,) in deck if kind == "off_library" for c in causes} <= set(
        OFF_LIBRARY
    )


def test_the_same_seed_gives_the_same_file_and_another_does_not(tmp_path):
    index = index_of(3, "none")
    first = write_case(3, index, tmp_path / "a")
    again = write_case(3, index, tmp_path / "b")
    assert first == again
    for name in ("run1.csv", "run4.csv", "logset.yaml"):
        assert (tmp_path / "a" / name).read_bytes() == (tmp_path / "b" / name).read_bytes()
    write_case(4, index_of(4, "none"), tmp_path / "c")
    assert (tmp_path / "a" / "run1.csv").read_bytes() != (tmp_path / "c" / "run1.csv").read_bytes()


def test_the_log_set_withholds_its_answer_and_states_its_motion(tmp_path):
    index = index_of(3, "single")
    answer = write_case(3, index, tmp_path)
    text = (tmp_path / "logset.yaml").read_text()
    assert "answer" not in text
    assert not any(cause in text for cause in answer["cause"])
    described = yaml.safe_load(text)
    assert len(described["runs"]) == 6
    for run in described["runs"]:
        table = np.loadtxt(tmp_path / run["file"], delimiter=",", skiprows=1)
        t, stroke, _ = out_and_back(run["rate_Hz"], 3)
        expected = stroke[:, None] * AMPLITUDE[run["motion"]]
        assert table[:, 0] == pytest.approx(t, abs=5.1e-4)
        assert table[:, 1:3] == pytest.approx(expected, abs=5.1e-7)


@pytest.mark.parametrize("machine", [Machine, Slider])
def test_no_effect_means_the_stated_machine_within_tolerance(tmp_path, machine):
    index = index_of(6, "none", machine)
    case = cases.draw(6, index)
    answer = write_case(6, index, tmp_path)
    assert answer["answer"] == []
    assert answer["strength"]["all"] == 0.0
    jittered = {"mass", "turning_inertia", "rotor_inertia", "beta", "gamma", "viscous"}
    for name, stated in machine()._asdict().items():
        if name in jittered:
            ratio = np.divide(getattr(case.machine, name), stated)
            assert np.all(np.abs(ratio - 1) <= 0.03)
            assert np.all(ratio != 1)
        else:
            assert getattr(case.machine, name) == stated


def test_a_slider_is_logged_in_the_layout_of_the_measured_one(tmp_path):
    index = index_of(6, "single", Slider)
    write_case(6, index, tmp_path)
    described = yaml.safe_load((tmp_path / "logset.yaml").read_text())
    assert described["system"]["kind"] == "slider"
    assert {run["use"] for run in described["runs"]} == {"fit", "validate"}
    lines = (tmp_path / "run1.csv").read_text().splitlines()
    assert lines[0] == "t,q_ref,q,u,force"
    table = np.loadtxt(lines[1:], delimiter=",")
    assert table[:, 4] == pytest.approx(35.15065188248547 * table[:, 3], abs=1e-4)


def test_a_dry_machine_moves_the_residual_and_a_copy_does_not():
    case = cases.draw(3, index_of(3, "none"))
    tables = drive_logset.simulate(case, case.nominal)
    assert strength.strength(tables, tables, range(6), drive_logset.SIGNALS) == 0.0
    even = (0.3, 0.3)
    dry = case.nominal._replace(coulomb=(even, even, (0.0, 0.0)))
    moved = drive_logset.simulate(case, dry)
    assert strength.strength(moved, tables, range(6), drive_logset.SIGNALS) > 5.0
    late = [*tables[:4], *moved[4:]]
    assert strength.strength(late, tables, range(4), drive_logset.SIGNALS) == 0.0


@pytest.mark.parametrize(
    ("machine", "effect"),
    [(Machine(), e) for e in (EFFECTS | OFF_LIBRARY).values()]
    + [(Slider(), e) for e in slider_effects.EFFECTS.values()],
)
def test_every_effect_keeps_the_types_the_kernel_was_compiled_for(machine, effect):
    """A changed type would recompile the kernel for seconds, or fail to."""
    for seed in range(8):
        changed, parameters = effect(np.random.default_rng(seed), machine)
        for field, default in zip(machine._fields, machine):
            assert type(getattr(changed, field)) is type(default), field
        assert parameters


def test_a_slider_that_always_runs_away_gives_way_to_the_drive(monkeypatch):
    index = index_of(6, "single", Slider)
    drawn = cases.draw(6, index)
    monkeypatch.setattr(cases, "steady", lambda case: not isinstance(case.machine, Slider))
    other = cases.draw(6, index)
    assert isinstance(other.machine, Machine)
    assert other.cause == drawn.cause


def test_a_pair_that_always_runs_away_gives_way_to_another(monkeypatch):
    index = index_of(6, "double")
    drawn = cases.draw(6, index)
    monkeypatch.setattr(cases, "steady", lambda case: case.cause != drawn.cause)
    other = cases.draw(6, index)
    assert other.kind == "double"
    assert other.cause != drawn.cause
    with monkeypatch.context() as patched:
        patched.setattr(cases, "steady", lambda case: False)
        with pytest.raises(RuntimeError, match="all ran away"):
            cases.draw(6, index)
