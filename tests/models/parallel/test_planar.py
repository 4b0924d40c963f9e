"""Five-bar, RePlaLink and 2-PRR: kinematics, energy, the plant with closures, and the printed numbers."""

from dataclasses import replace

import numpy as np
import pytest

from gapscope.models.parallel import chains, energy, five_bar, two_prr
from gapscope.models.parallel.five_bar import FiveBar
from gapscope.models.parallel.replalink import REPLALINK
from gapscope.models.parallel.two_prr import TwoPRR
from gapscope.systems.closed_chain import ClosedChain

# Gravity on, so that the oracle sees it.
FIVE = [replace(FiveBar(), rotors=(0.02, 0.03), weight=9.81), replace(REPLALINK, weight=9.81)]
PRR = TwoPRR()


def samples(n=40, seed=61):
    rng = np.random.default_rng(seed)
    return rng.uniform(size=(n, 2)), rng.normal(size=(n, 2)), 5.0 * rng.normal(size=(n, 2))


def cranks(unit):
    # The rods of both five-bars meet over all of this square.
    return np.array([1.7, 0.8]) + 0.5 * unit


def sliders(unit):
    return 0.1 + 0.25 * unit


def case(name):
    """Motion law, posture sampler, masses, inertias, weight of a machine."""
    if name == "2prr":
        m = PRR
        return lambda q, v: two_prr.motion(q, v, m), sliders, m.masses, m.body_inertias, m.weight
    m = FIVE[name == "replalink"]
    law = lambda q, v: five_bar.motion(q, v, m)  # noqa: E731
    return law, cranks, m.body_masses, m.body_inertias, m.weight


MACHINES = ("5r", "replalink", "2prr")


def chain_of(name):
    """Tree plant of a machine with its closures."""
    chain = chains.two_prr(PRR) if name == "2prr" else chains.five_bar(FIVE[name == "replalink"])
    return ClosedChain(chain)


@pytest.mark.parametrize("name", MACHINES)
def test_accelerations_are_those_of_the_plant_with_closures(name):
    law, posture, mass, inertia, weight = case(name)
    chain = chain_of(name)
    force = np.array([30.0, -20.0])
    for unit, v, _ in zip(*samples()):
        q = posture(unit)
        plant = chain.project(chain.close(q), v)
        assert chain.gap() < 1e-12
        assert plant.rank == (4 if name == "2prr" else 2)
        expected = np.linalg.solve(plant.matrix, force - plant.bias)
        closed = energy.equations(law(q, v), mass, inertia, weight).acceleration(force)
        assert closed == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", MACHINES)
def test_drift_is_the_derivative_of_the_jacobian(name):
    """Central differences with h = 1e-6 err by eps / h, 1e-9 of the size of J, times the rates."""
    law, posture, *_ = case(name)
    h = 1e-6
    for unit, v, _ in zip(*samples()):
        q = posture(unit)
        ahead, behind = (law(q + s * h * v, v).jacobian for s in (1.0, -1.0))
        numeric = ((ahead - behind) / (2.0 * h)) @ v
        drift = law(q, v).drift
        assert drift == pytest.approx(numeric, rel=1e-6, abs=1e-7 * (1.0 + np.abs(drift).max()))


@pytest.mark.parametrize("name", MACHINES)
def test_power_is_the_rate_of_energy(name):
    """Without gravity: f . v is the derivative of v . I v / 2 along any motion."""
    law, posture, mass, inertia, _ = case(name)
    h = 1e-5
    for unit, v, a in zip(*samples(seed=63)):
        q = posture(unit)

        def kinetic(t, q=q, v=v, a=a):
            rates = v + a * t
            at = law(q + v * t + 0.5 * a * t * t, rates)
            return 0.5 * rates @ energy.equations(at, mass, inertia, 0.0).inertia @ rates

        force = energy.equations(law(q, v), mass, inertia, 0.0).force(a)
        assert (kinetic(h) - kinetic(-h)) / (2.0 * h) == pytest.approx(
            force @ v, rel=1e-5, abs=1e-5
        )


@pytest.mark.parametrize("name", MACHINES)
def test_regressor_times_parameters_is_the_force(name):
    law, posture, mass, inertia, weight = case(name)
    unit, v, a = samples(seed=65)
    at = law(posture(unit), v)
    parameters = np.concatenate([mass, inertia])
    force = energy.equations(at, mass, inertia, weight).force(a)
    assert energy.regressor(at, a, weight) @ parameters == pytest.approx(force, rel=1e-11, abs=1e-9)


@pytest.mark.parametrize("modes", [(1, -1), (-1, 1), (1, 1), (-1, -1)])
def test_forward_undoes_inverse_of_the_five_bar(modes):
    for machine in FIVE:
        p = np.array([[0.1, 0.8], [-0.2, 0.7], [0.0, 0.9]])
        q = five_bar.inverse(p, machine, modes)
        assert np.isfinite(q).all()
        tools = np.stack([five_bar.forward(q, machine, side).tool for side in (1, -1)])
        assert np.abs(tools - p).max(axis=-1).min(axis=0) == pytest.approx(0.0, abs=1e-12)


def test_five_bar_out_of_reach_is_nan():
    assert np.isnan(five_bar.inverse([2.0, 0.0], FiveBar())).any()


@pytest.mark.parametrize("modes", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_inverse_of_the_2prr_reaches_the_platform(modes):
    """Bars of length L join sliders and platform in each working mode; mode (1, 1) undoes forward."""
    p = np.array([[0.5, -0.45], [0.7, -0.6]])
    q = two_prr.inverse(p, PRR, modes)
    for x in (q[:, 0] + PRR.offset, PRR.span - q[:, 1]):
        assert np.hypot(p[:, 0] - x, p[:, 1]) == pytest.approx([PRR.bar] * 2, abs=1e-14)
    if modes == (1, 1):
        assert two_prr.forward(q, PRR) == pytest.approx(p, abs=1e-14)


def test_a_length_must_be_positive():
    with pytest.raises(ValueError, match=r"base is 0.0; expected a length"):
        FiveBar(base=0.0)
    with pytest.raises(ValueError, match="bar is -1"):
        TwoPRR(bar=-1.0)


def test_lengths_of_the_replalink_reproduce_the_printed_base_parameters():
    """Coefficients of I1..I4 on m1..m5 in (6.51)-(6.55), printed to 4-5 digits; the base distance plays no part."""
    unit, v, a = samples(200, seed=67)
    k = energy.regressor(five_bar.motion(cranks(unit), v, REPLALINK), a, 0.0).reshape(-1, 14)
    printed = np.array(
        [
            [27.686, 13.533, 0.51015, 0.0],
            [0.0, -6.8439, 7.2328, 0.0],
            [0.0, 0.0, -16.299, 0.0],
            [0.0, 0.0, 66.007, 35.225],
            [0.0, 4.43, -0.27833, 0.0],
        ]
    )
    found = np.linalg.lstsq(k[:, :5], k[:, 7:11], rcond=None)[0]
    assert found == pytest.approx(printed, rel=2e-3, abs=2e-2)


def test_base_parameters_of_the_2prr():
    """Masses of (6.27)-(6.30): m5 counts as m3 less half a slider 1 plus half a slider 2; bars 3 and 4 alike."""
    unit, v, a = samples(200, seed=69)
    k = energy.regressor(two_prr.motion(sliders(unit), v, PRR), a, PRR.weight).reshape(-1, 12)
    m1, m2, m3, m4, m5 = k[:, :5].T
    assert m4 == pytest.approx(m3)
    assert m5 == pytest.approx(m3 - 0.5 * m1 + 0.5 * m2, rel=1e-11, abs=1e-11)
    assert np.linalg.matrix_rank(k) == 4
