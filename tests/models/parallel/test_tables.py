"""2PRU-1PRS and 3-PRS tables: kinematics, Boltzmann-Hamel, the plant with closures, and the printed numbers."""

from dataclasses import replace

import numpy as np
import pytest

from gapscope.models.parallel import bodies, chains, energy, prs, rotation, three_prs
from gapscope.models.parallel.mast import MAST, printed_jacobians
from gapscope.models.parallel.three_prs import THREE_PRS
from gapscope.systems.closed_chain import ClosedChain

# A centre of mass off P and a full tensor, so that the oracle sees every term.
SKEW = (0.06, 0.07, 0.12, 0.004, -0.003, 0.005)
TABLES = {
    "mast": replace(
        MAST, platform_centre=(0.02, -0.01, 0.03), platform_inertia=SKEW, carriage_mass=0.4
    ),
    "3prs": replace(
        THREE_PRS,
        platform_centre=(0.004, -0.003, 0.006),
        platform_inertia=tuple(1e-3 * value for value in SKEW),
    ),
}
# Half-widths of z [m], psi and theta [rad].
REACH = {"mast": (0.03, 0.3, 0.3), "3prs": (0.004, 0.03, 0.03)}
NAMES = tuple(TABLES)


def samples(name, n=40, seed=71):
    table, rng = TABLES[name], np.random.default_rng(seed)
    task = np.array([table.home, 0.0, 0.0]) + rng.uniform(-1.0, 1.0, (n, 3)) * REACH[name]
    rates = rng.normal(size=(n, 3)) * table.radius
    return table, task, rates, 10.0 * rng.normal(size=(n, 3)) * table.radius


def chain_of(name):
    return ClosedChain(
        chains.mast(TABLES[name]) if name == "mast" else chains.three_prs(TABLES[name])
    )


@pytest.mark.parametrize("name", NAMES)
def test_accelerations_are_those_of_the_plant_with_closures(name):
    """Ranks 7 of 9 and 6 of 6 leave three freedoms in each."""
    table, task, v, _ = samples(name)
    chain, force = chain_of(name), np.array([3.0, -2.0, 5.0])
    for x, rate in zip(task, v):
        q = prs.inverse(x, table)
        plant = chain.project(chain.close(q), rate)
        assert (plant.rank, plant.rows) == ((7, 9) if name == "mast" else (6, 6))
        assert chain.plant.num_velocities() - plant.rank == 3
        expected = np.linalg.solve(plant.matrix, force - plant.bias)
        closed = prs.dynamics(q, rate, table).acceleration(force)
        assert closed == pytest.approx(expected, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("name", NAMES)
def test_drift_is_the_derivative_of_the_jacobian(name):
    """Central differences with h = 1e-6 err by eps / h of J, times the rates."""
    table, task, v, _ = samples(name)
    q, h = prs.inverse(task, table), 1e-6
    ahead, behind = (
        prs.motion(prs.forward(q + s * h * v, table, task), v, table).jacobian for s in (1.0, -1.0)
    )
    numeric = np.einsum("...bij,...j->...bi", (ahead - behind) / (2.0 * h), v)
    drift = prs.motion(task, v, table).drift
    assert drift == pytest.approx(numeric, rel=1e-6, abs=1e-8 * np.abs(drift).max())


@pytest.mark.parametrize("name", NAMES)
def test_power_is_the_rate_of_energy(name):
    """Without gravity: f . v is the derivative of v . I v / 2 along any motion."""
    table, task, v, a = samples(name, seed=73)
    q, h = prs.inverse(task, table), 1e-5

    def kinetic(t):
        at = prs.dynamics(q + v * t + 0.5 * a * t * t, v + a * t, table, None)
        rates = v + a * t
        return 0.5 * np.einsum("...i,...ij,...j->...", rates, at.inertia, rates)

    force = prs.dynamics(q, v, replace(table, weight=0.0)).force(a)
    power = np.einsum("...i,...i->...", force, v)
    rate = (kinetic(h) - kinetic(-h)) / (2.0 * h)
    assert rate == pytest.approx(power, rel=1e-5, abs=1e-6 * np.abs(power).max())


@pytest.mark.parametrize("name", NAMES)
def test_gravity_is_the_slope_of_the_potential(name):
    table, task, v, _ = samples(name)
    q, h = prs.inverse(task, table), 1e-6

    def potential(x):
        at = prs.pose(x, table)
        s = prs.inverse(x, table)
        bars = at.joints - 0.5 * prs.bars(at, s, table)
        centre = at.position + at.rotation @ np.array(table.platform_centre)
        slides = s * table.slide[1]
        heights = (
            table.bar_mass * bars[..., 2].sum(-1)
            + table.platform_mass * centre[..., 2]
            + table.carriage_mass * slides.sum(-1)
        )
        return table.weight * heights

    slope = np.stack(
        [
            potential(prs.forward(q + h * e, table, task))
            - potential(prs.forward(q - h * e, table, task))
            for e in np.eye(3)
        ],
        axis=-1,
    ) / (2.0 * h)
    assert prs.dynamics(q, v, table).gravity == pytest.approx(slope, rel=1e-6, abs=1e-6)


@pytest.mark.parametrize("name", NAMES)
def test_both_regressors_give_the_force(name):
    """The closed form in masses and tensors about the centres; any chain in ten parameters a body."""
    table, task, v, a = samples(name, n=8, seed=75)
    at, force = (
        prs.motion(task, v, table),
        prs.dynamics(prs.inverse(task, table), v, table).force(a),
    )
    own = np.concatenate([table.masses, table.inertias.ravel()])
    assert energy.spatial_regressor(at, a, table.weight) @ own == pytest.approx(
        force, rel=1e-10, abs=1e-9
    )
    chain = chain_of(name)
    ten = np.concatenate(
        [bodies.parameters(b.mass, b.centre, b.inertia) for b in chain.chain.links]
    )
    for x, rate, acceleration, expected in zip(task, v, a, force):
        motion = chain.motion(chain.close(prs.inverse(x, table)), rate)
        assert bodies.regressor(motion, acceleration) @ ten == pytest.approx(
            expected, rel=1e-9, abs=1e-9
        )


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("modes", [(-1, -1, -1), (1, -1, -1), (1, 1, 1)])
def test_inverse_closes_the_legs_and_forward_undoes_it(name, modes):
    table, task, _, _ = samples(name)
    q, at = prs.inverse(task, table, modes), prs.pose(task, table)
    lengths = np.linalg.norm(prs.bars(at, q, table), axis=-1)
    assert lengths == pytest.approx(np.full(lengths.shape, table.bar), abs=1e-13)
    assert np.abs(np.einsum("ki,...ki->...k", table.across, at.joints)).max() < 1e-14
    if modes == (-1, -1, -1):
        assert prs.forward(q, table) == pytest.approx(task, abs=1e-12)


def test_out_of_reach_is_nan():
    assert np.isnan(prs.inverse([0.2, 0.0, 1.2], MAST)).any()
    assert np.isnan(prs.forward([0.0, 0.9, 0.0], MAST)).all()


def test_printed_jacobians_of_the_mast():
    """(B.28) with two signs and an index corrected."""
    _, task, _, _ = samples("mast")
    by_task, by_slider = printed_jacobians(task)
    printed = np.linalg.solve(by_task, by_slider)
    assert prs.task_jacobian(task, prs.inverse(task, MAST), MAST) == pytest.approx(
        printed, abs=1e-12
    )


def test_parasitic_motions_follow_from_the_leg_planes():
    """(13)-(15) of the article for the 3-PRS; x alone for the MAST."""
    rng = np.random.default_rng(77)
    psi, theta = rng.uniform(-0.3, 0.3, (2, 50))
    task = np.stack([0.0 * psi, psi, theta], axis=-1)
    at = prs.pose(task, THREE_PRS)
    found = np.concatenate([at.position[:, :2], at.phi[:, None]], axis=1)
    assert found == pytest.approx(three_prs.parasitic(psi, theta), abs=1e-15)
    level = prs.pose(task, MAST)
    assert level.position[:, 0] == pytest.approx(-MAST.radius * np.sin(psi) * np.sin(theta))
    assert np.abs(level.phi).max() < 1e-15
    assert np.abs(level.position[:, 1]).max() < 1e-15


def test_boltzmann_hamel_in_euler_angles_is_the_moment_in_the_body():
    """(3.60)-(3.70) and (3.64) are one equation, away from the singular nutation."""
    rng = np.random.default_rng(79)
    angles = rng.uniform(0.4, 2.6, (50, 3))
    rates, accelerations = rng.normal(size=(2, 50, 3))
    tensor = rotation.inertia_tensor(SKEW)
    into_w = rotation.euler_matrix(angles)
    dot = np.einsum("...kij,...k->...ij", rotation.euler_derivatives(angles), rates)
    w = np.einsum("...ij,...j->...i", into_w, rates)
    turn = np.einsum("...ij,...j->...i", dot, rates) + np.einsum(
        "...ij,...j->...i", into_w, accelerations
    )
    forces = rotation.euler_forces(angles, rates, accelerations, tensor)
    moment = np.linalg.solve(np.swapaxes(into_w, -1, -2), forces[..., None])[..., 0]
    assert moment == pytest.approx(rotation.body_moment(w, turn, tensor), rel=1e-10, abs=1e-12)


def test_requirement_figures_of_the_3prs():
    """Travel -2.15..2.30 mm, revolute 1.7, bending 1.9 and 0.2, torsion 0.2 deg (section 4), one unit of print."""
    tilt = np.deg2rad([-0.2, 0.0, 0.2])
    task = np.stack(np.meshgrid([-2e-3, 0.0, 2e-3], tilt, tilt), axis=-1).reshape(-1, 3)
    task = task + np.array([THREE_PRS.home, 0.0, 0.0])
    travel = 1e3 * prs.inverse(task, THREE_PRS)
    assert travel.min() == pytest.approx(-2.15, abs=0.05)
    assert travel.max() == pytest.approx(2.30, abs=0.05)
    angles = three_prs.joint_angles(task)
    largest = [np.rad2deg(np.abs(part).max()) for part in angles[1:]]
    assert np.rad2deg(np.abs(angles.revolute - three_prs.SLOPE).max()) == pytest.approx(
        1.7, abs=0.1
    )
    assert largest == pytest.approx([1.9, 0.2, 0.2], abs=0.1)


def test_a_table_refuses_what_cannot_be():
    with pytest.raises(ValueError, match=r"bar is 0\.0; expected a length"):
        replace(MAST, bar=0.0)
    with pytest.raises(ValueError, match="expected a direction"):
        replace(MAST, slide=(1.0, 1.0))
