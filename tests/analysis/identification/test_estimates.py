"""Planted parameters are recovered from the plant's forces, honest about what they do not show."""

import json
from dataclasses import replace

import numpy as np
import pytest
import scipy.signal
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from typer.testing import CliRunner

from gapscope.analysis.cli import app
from gapscope.analysis.identification import (
    estimate,
    excitation,
    feasible,
    machines,
    measurement,
    study,
)
from gapscope.analysis.identification.base import Base
from gapscope.models.parallel import sdf
from gapscope.systems import closures
from gapscope.systems.closed_chain import ClosedChain


@pytest.fixture(scope="module")
def two_prr():
    """A short study of the 2-PRR with five harmonics, to be quick."""
    m = replace(machines.machine("2prr"), harmonics=5)
    return study.run(m, methods=("evolution",), budget=1200, seed=3, repeats=20)


@pytest.fixture(scope="module")
def mast():
    m = replace(machines.machine("mast"), harmonics=2)
    return study.run(m, methods=("evolution",), budget=120, seed=3, repeats=0)


def test_forces_of_the_plant_are_those_of_the_regressor():
    """Fourier interpolation between the plant's instants included."""
    m = machines.machine("replalink")
    rigid = m.truth(1)
    motion = measurement.Sinusoid(m.start, 0.1, 1.0)
    what = measurement.ideal(m, rigid, motion)
    t = m.period * np.arange(len(what.force))
    parameters = np.concatenate([rigid, m.coulomb, m.viscous])
    expected = m.full_regressor(*motion.sample(t)) @ parameters
    assert what.force == pytest.approx(expected, rel=1e-9, abs=1e-9)


def test_rows_at_rest_do_not_guess_the_sign_of_friction():
    """5R, whose cycles start at rest: without noise the planted parameters leave next to none of 12 N m."""
    m = replace(machines.machine("5r"), noise=0.0)
    rigid, kept = m.truth(0), study.structure(m, 0)[0].kept
    exact = measurement.ideal(m, rigid, study.Moving(excitation.random(m, kept, 0)))
    data = measurement.measure(m, exact, 0)
    left = data.force - data.regressor @ np.concatenate([rigid, m.coulomb, m.viscous])
    assert np.abs(left).max() < 0.02  # the filters have settled at both ends
    assert 500 < len(left) < 2 * 4 * 2.0 / 0.025
    assert data.time.shape == data.axis.shape == data.force.shape


def test_intervals_hold_the_planted_parameters(two_prr):
    """20 repetitions of the noise, 160 intervals of 95 %: the count is within what chance allows (99.9 %)."""
    assert two_prr.covered.shape == (20, 8)
    assert two_prr.covered.mean() > 0.88


def test_neighbouring_rows_err_alike():
    """Slow regressors behind the filter of ``measure``, 1000 draws: rows taken as independent claim 7 % too little."""
    dt, cutoff, draws, each = 1e-3, 20.0, 1000, 25
    t = dt * np.arange(10_000)
    columns = np.stack([np.ones_like(t), np.sin(6.0 * t), np.cos(9.0 * t)], axis=1)[300:-300:each]
    low = scipy.signal.butter(3, cutoff, fs=1.0 / dt, output="sos")
    noise = np.random.default_rng(7).normal(size=(t.size, draws))
    force = scipy.signal.sosfiltfilt(low, noise, axis=0)[300:-300:each]
    rows, axis = len(columns), np.zeros(len(columns), dtype=int)
    shared = measurement.noise_correlation(low, each)
    kept = Base(kept=(0, 1, 2), combination=np.eye(3), singular=np.ones(3))

    def spread(correlation):
        data = [
            measurement.Regression(columns, f, axis, np.arange(float(rows)), 1.0, correlation)
            for f in force.T
        ]
        found = [estimate.fit(one, kept, 1) for one in data]
        claimed = np.mean([fit.half_width for fit in found], axis=0) / 1.966  # t for 370 rows
        return float(np.mean(np.std([fit.values for fit in found], axis=0) / claimed))

    assert spread(shared) == pytest.approx(1.0, abs=0.04)
    assert spread(np.ones(1)) > 1.04
    assert shared[1] == pytest.approx(
        np.corrcoef(force[:-1].ravel(), force[1:].ravel())[0, 1], abs=0.01
    )


def test_completions_are_as_many_as_printed(two_prr):
    """21 combinations, 15 usable (6.1.6); 210 and 64 for the RePlaLink (6.2.6)."""
    assert (two_prr.completion.total, two_prr.completion.usable) == (21, 15)
    m = machines.machine("replalink")
    base, _, _ = study.structure(m, 0)
    truth = np.concatenate([m.truth(0), m.coulomb, m.viscous])
    w = m.full_regressor(*m.random_states(50, 0)).reshape(-1, len(m.names))
    data = measurement.Regression(w, w @ truth, np.tile([0, 1], 50), np.repeat(np.arange(50.0), 2))
    found = estimate.complete(m, base, base.combination @ truth, data)
    assert (found.total, found.usable) == (210, 64)


def test_feasible_parameters_can_exist_and_predict(two_prr):
    """Plain least squares fits as well with masses below zero."""
    m = two_prr.machine
    assert feasible.smallest_margins(m, two_prr.feasible)["smallest_scalar"] > 0.0
    assert feasible.smallest_margins(m, two_prr.plain)["smallest_scalar"] < 0.0
    errors = two_prr.errors
    assert errors["feasible"] < 1.1 * errors["planted"] < 0.1 * errors["theoretical, no friction"]


def test_noise_is_told_by_a_motion_measured_twice():
    """RePlaLink: noise decides which rows count as at rest, so that two measurements differ in length."""
    m = machines.machine("replalink")
    kept = study.structure(m, 0)[0].kept
    exact = measurement.ideal(m, m.truth(0), study.Moving(excitation.random(m, kept, 1000)))
    one, other = (measurement.measure(m, exact, seed) for seed in (1, 2))
    assert len(one.force) != len(other.force)
    # A Butterworth filter of third order run both ways leaves 0.873 of its cutoff's band.
    left = m.noise * np.sqrt(2.0 * 0.873 * m.cutoff * m.period)
    size = np.sqrt(np.mean(one.force**2))
    assert study.noise(one, other, m) == pytest.approx(left / size, rel=0.15)


@pytest.mark.slow
def test_a_tensor_that_the_forces_do_not_show_stays_valid(mast):
    margins = feasible.smallest_margins(mast.machine, mast.feasible)
    assert margins["smallest_eigenvalue"] > -1e-8
    assert margins["smallest_scalar"] > 0.0
    assert mast.errors["feasible"] < 0.2 * mast.errors["theoretical, no friction"]


@pytest.mark.parametrize("name", ["2prr", "replalink", "mast", "3prs"])
def test_sdf_is_the_machine(name, tmp_path):
    """Parsed by Drake: the mass matrix of the chain's own plant; closures come back."""
    m = machines.machine(name)
    chain = m.chain(m.truth(2))
    (tmp_path / "m.sdf").write_text(sdf.sdf(chain, {chain.driven[0]: 3.0}))
    (tmp_path / "closures.yaml").write_text(sdf.closures(chain))
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(tmp_path / "m.sdf"))
    plant.Finalize()
    own = ClosedChain(chain)
    q, context = own.close(m.start), plant.CreateDefaultContext()
    positions, order = plant.GetPositions(context), []
    for link in chain.links:
        joint, twin = (
            plant.GetJointByName(f"{link.name}_joint"),
            own.plant.GetJointByName(link.name),
        )
        at, there, size = joint.position_start(), twin.position_start(), joint.num_positions()
        positions[at : at + size] = q[there : there + size]
        order += [
            (joint.velocity_start() + k, twin.velocity_start() + k)
            for k in range(joint.num_velocities())
        ]
    plant.SetPositions(context, positions)
    own.plant.SetPositions(own.context, q)
    here, there = np.array(order).T
    mass = plant.CalcMassMatrix(context)[np.ix_(here, here)]
    expected = own.plant.CalcMassMatrix(own.context)[np.ix_(there, there)]
    assert mass == pytest.approx(expected, rel=1e-12, abs=1e-12)
    assert closures.load(tmp_path / "closures.yaml") == list(chain.closures)


def test_command_writes_a_report(tmp_path):
    done = CliRunner().invoke(
        app,
        ["identify", "2prr", "--out", str(tmp_path), "--methods", "evolution",
         "--budget", "500", "--repeats", "2"],
    )  # fmt: skip
    assert done.exit_code == 0, done.output
    found = json.loads((tmp_path / "identification.json").read_text())
    assert found["base_parameters"]["count"] == found["base_parameters"]["printed"] == 8
    assert found["completion"]["usable"] == found["completion"]["printed"]["usable"]
    for name in ("excitation.png", "parameters.png", "validation.png", "2prr.sdf", "closures.yaml"):
        assert (tmp_path / name).stat().st_size > 100
