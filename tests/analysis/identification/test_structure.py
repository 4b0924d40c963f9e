"""Base parameters, joint space and exciting motions of the machines of chapter 6."""

from dataclasses import replace

import numpy as np
import pytest

from gapscope.analysis.errors import InputError
from gapscope.analysis.identification import (
    base,
    excitation,
    gradient,
    machine,
    machines,
    polygon,
    study,
)
from gapscope.models.parallel import chains
from gapscope.models.parallel.five_bar import FiveBar

COUNTS = {"2prr": 8, "replalink": 9, "5r": 9}


@pytest.mark.parametrize("name", COUNTS)
def test_number_of_base_parameters_is_the_printed_one(name):
    """8 and 9 (6.23-6.30, 6.47-6.55); SVD and QR keep other columns of the same space."""
    svd, qr, angle = study.structure(machines.machine(name), seed=0)
    assert (len(svd.kept), len(qr.kept)) == (COUNTS[name], COUNTS[name])
    assert svd.gap > 1e6
    assert angle < 1e-7


def test_printed_sums_of_the_2prr():
    """(6.27)-(6.30): printed 4.6625, 0.0092, 4.6417, -9.3088 stand for 2/L^2, 0, 2/L^2, -4/L^2."""
    m = machines.machine("2prr")
    svd, _, _ = study.structure(m, seed=1)
    table = {m.names[k]: dict(zip(m.names, row)) for k, row in zip(svd.kept, svd.combination)}
    share = 2.0 / 0.654**2
    assert table["m1"]["m5"] == pytest.approx(-0.5)
    assert table["m2"]["m5"] == pytest.approx(0.5)
    assert table["m3"]["m4"] == pytest.approx(1.0)
    assert [table[k]["I4"] for k in ("m1", "m6", "m3")] == pytest.approx([share, share, -2 * share])
    assert share == pytest.approx(4.66, abs=0.02)
    assert table["Fc1"] == {name: float(name == "Fc1") for name in m.names}


def test_printed_sums_of_the_replalink():
    """(6.51)-(6.55), printed to 4-5 digits; the lengths were recovered from them to 0.2 %."""
    m = machines.machine("replalink")
    svd, _, _ = study.structure(m, seed=1)
    table = {m.names[k]: dict(zip(m.names, row)) for k, row in zip(svd.kept, svd.combination)}
    printed = {
        "m1": {"I1": 27.686, "I2": 13.533, "I3": 0.51015, "I6": 27.686},
        "m2": {"I2": -6.8439, "I3": 7.2328},
        "m3": {"I3": -16.299},
        "m4": {"I3": 66.007, "I4": 35.225, "I7": 35.225},
        "m5": {"I2": 4.43, "I3": -0.27833},
    }
    for kept, shares in printed.items():
        for name in ("I1", "I2", "I3", "I4", "I6", "I7"):
            assert table[kept][name] == pytest.approx(shares.get(name, 0.0), rel=3e-3, abs=1e-9)


def test_base_of_a_chain_known_by_its_bodies_alone():
    """Ten parameters a body, motion from the plant: the forces of the closed form lie in the same space."""
    m = machines.machine("2prr")
    limits = {
        name: getattr(m, name)
        for name in (
            "lower", "upper", "speed", "acceleration", "start", "frequency", "harmonics",
            "period", "cutoff", "resolution", "coulomb", "viscous", "noise",
        )
    }  # fmt: skip
    generic = machine.of_chain(m.chain(m.prior), **limits)
    states = m.random_states(40, 3)
    wide = generic.full_regressor(*states)
    flat = wide.reshape(-1, wide.shape[-1])
    found = base.by_svd(flat)
    # First moments along and across each bar and pulls of both are seen beside the four of known centres.
    assert len(found.kept) > 8
    assert found.gap > 1e6
    narrow = m.full_regressor(*states).reshape(-1, len(m.names))
    force = narrow @ np.concatenate([m.prior, m.coulomb, m.viscous])
    own = np.concatenate([generic.prior, m.coulomb, m.viscous])
    assert flat @ own == pytest.approx(force, rel=1e-9, abs=1e-8)
    assert flat[:, list(found.kept)] @ (found.combination @ own) == pytest.approx(
        force, rel=1e-8, abs=1e-7
    )


def test_condition_number_is_numpys():
    w = np.random.default_rng(5).normal(size=(3, 30, 6)) * np.logspace(0, 2, 6)
    assert base.condition(w) == pytest.approx(np.linalg.cond(w), rel=1e-8)
    w[1, 0, 0] = np.nan
    assert np.isinf(base.condition(w)[1])


def test_depth_in_a_polygon():
    """An L: inside of the notch is outside, and the nearest edge is that of the notch."""
    shape = [(0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)]
    depth = polygon.inside([[0.5, 0.5], [1.5, 1.5], [1.9, 0.5], [3.0, 0.0]], shape)
    assert depth == pytest.approx([0.5, -0.5, 0.1, -1.0])


@pytest.mark.parametrize("method", excitation.METHODS)
def test_search_improves_and_keeps_the_limits(method):
    m = replace(machines.machine("2prr"), harmonics=4, at_rest=True)
    kept = study.structure(m, 0)[0].kept
    first = excitation.of(m, kept, excitation.random(m, kept, 7))
    found = excitation.search(m, kept, method, budget=900, seed=7)
    q, v, a = found.excitation.sample(np.linspace(0.0, found.excitation.motion.period, 5000))
    assert found.condition < first
    assert (q >= m.lower).all()
    assert (q <= m.upper).all()
    assert (np.abs(v).max(axis=0) <= m.speed * (1 + 1e-5)).all()
    assert (np.abs(a).max(axis=0) <= m.acceleration * (1 + 1e-5)).all()
    assert np.abs(v[0]).max() < 1e-12


@pytest.mark.parametrize("name", ["2prr", "replalink"])
def test_slopes_of_the_gradient_search_are_those_of_its_values(name):
    """Condition number, and depth in the polygon where there is one, by central differences."""
    m = machines.machine(name)
    problem = gradient.Problem(excitation.Objective(m, study.structure(m, 0)[0].kept))
    z = problem.start(np.random.default_rng(0))
    assert (problem.rows @ z <= problem.high + 1e-9).all()
    assert (problem.rows @ z >= problem.low - 1e-9).all()
    laws = [problem.value] if m.polygon is None else [problem.value, problem.depth]
    for law in laws:
        along = [(np.asarray(law(z + e)[0]) - law(z - e)[0]) / 2e-5 for e in 1e-5 * np.eye(z.size)]
        slope = law(z)[1]
        assert slope == pytest.approx(np.array(along).T, abs=5e-3 * np.abs(slope).max())


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_condition_number_of_the_2prr_is_reached(seed):
    """20.78 printed (6.1.4), by the series of (6.18)-(6.20), whose cycles start on the move; default search."""
    m = machines.machine("2prr")
    assert not m.at_rest
    kept = study.structure(m, 0)[0].kept
    found = excitation.search(m, kept, "gradient", budget=m.budget, seed=seed)
    q, v, a = found.excitation.sample(np.linspace(0.0, found.excitation.motion.period, 5000))
    assert (q >= m.lower).all()
    assert (q <= m.upper).all()
    assert (np.abs(v).max(axis=0) <= m.speed * (1 + 1e-5)).all()
    assert (np.abs(a).max(axis=0) <= m.acceleration * (1 + 1e-5)).all()
    assert found.condition <= 20.78


@pytest.mark.parametrize("method", ["gradient", "evolution"])
def test_motion_stays_in_the_polygon_and_beats_the_printed_condition_number(method):
    """RePlaLink: 62.21 printed with the pattern search, far from the best of this joint space."""
    m = machines.machine("replalink")
    kept = study.structure(m, 0)[0].kept
    found = excitation.search(m, kept, method, budget=900, seed=0)
    q, _, _ = found.excitation.sample(np.linspace(0.0, found.excitation.motion.period, 500))
    assert (polygon.inside(q, m.polygon) > 0.0).all()
    assert found.condition <= 62.21


def test_joint_space_refuses_a_start_outside():
    with pytest.raises(ValueError, match="outside of the joint space"):
        machines.joint_space(FiveBar(), np.zeros(2), np.ones(2), np.array([5.0, 5.0]))


def test_unknown_names_list_the_known_ones():
    with pytest.raises(InputError, match="one of 2prr, replalink"):
        machines.machine("stewart")
    with pytest.raises(InputError, match="one of gradient, pattern"):
        excitation.search(machines.machine("2prr"), (0,), "magic", 100, 0)


def test_chains_share_the_prior_with_the_regressors():
    m = machines.machine("5r")
    links = {
        link.name: link for link in chains.five_bar(replace(FiveBar(), rotors=(0.05, 0.05))).links
    }
    assert m.chain(m.prior).links[0].mass == links["crank1"].mass
