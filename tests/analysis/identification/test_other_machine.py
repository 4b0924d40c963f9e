"""A machine that is none of the package's: a slider-crank in the gravity field, given by bodies and closure alone."""

from types import SimpleNamespace

import numpy as np
import pytest

from gapscope.analysis.identification import excitation, figures, machine, measurement, study
from gapscope.analysis.identification.estimate import fit
from gapscope.models.closure import Closure
from gapscope.models.parallel.chain import Chain, planar

CRANK, ROD, START = 0.05, 0.2, 0.9  # [m, m, rad]
MASSES, INERTIAS, CENTRES = (1.2, 0.8, 2.5), (2e-3, 3e-3), (0.02, 0.09)
COULOMB, VISCOUS = 0.3, 0.1  # [N m, N m s/rad]


def slope(angle):
    """Of the rod against the slide [rad]."""
    return -np.arcsin(CRANK * np.sin(angle) / ROD)


def slider_crank():
    at = CRANK * np.cos(START) + ROD * np.cos(slope(START))
    return Chain(
        name="slider_crank",
        links=(
            planar("crank", "world", "revolute", (0, 0), MASSES[0], CENTRES[0], INERTIAS[0]),
            planar("rod", "crank", "revolute", (CRANK, 0), MASSES[1], CENTRES[1], INERTIAS[1]),
            planar("slider", "world", "prismatic", mass=MASSES[2], inertia=0.1),
        ),
        closures=(Closure(type="ball", body_a="rod", body_b="slider", p_a=(ROD, 0.0, 0.0)),),
        driven=("crank",),
        gravity=(0.0, -9.81, 0.0),
        home=(START, slope(START) - START, at),
    )


@pytest.fixture(scope="module")
def generic():
    one = np.ones(1)
    return machine.of_chain(
        slider_crank(), title="slider-crank", lower=-0.2 * one, upper=2.0 * one, speed=8.0 * one,
        acceleration=150.0 * one, start=START * one, frequency=1.0, harmonics=4, period=0.01,
        cutoff=15.0, resolution=1e-5, coulomb=COULOMB * one, viscous=VISCOUS * one, noise=0.02,
    )  # fmt: skip


def torque(angle, rate, acceleration):
    """At the crank, by Lagrange from energies in the crank's angle alone."""

    def heights_and_slopes(q):
        tilt = slope(q)
        turn = -CRANK * np.cos(q) / (ROD * np.cos(tilt))  # of the rod per crank angle
        mid = (
            -CRANK * np.sin(q) - CENTRES[1] * np.sin(tilt) * turn,
            CRANK * np.cos(q) + CENTRES[1] * np.cos(tilt) * turn,
        )
        end = -CRANK * np.sin(q) - ROD * np.sin(tilt) * turn
        inertia = (
            INERTIAS[0] + MASSES[0] * CENTRES[0] ** 2 + INERTIAS[1] * turn**2
            + MASSES[1] * (mid[0] ** 2 + mid[1] ** 2) + MASSES[2] * end**2
        )  # fmt: skip
        weight = MASSES[0] * CENTRES[0] * np.cos(q) + MASSES[1] * mid[1]
        return inertia, 9.81 * weight

    step = 1e-6
    inertia, weight = heights_and_slopes(angle)
    ahead, behind = (heights_and_slopes(angle + s)[0] for s in (step, -step))
    return inertia * acceleration + 0.25 * (ahead - behind) / step * rate**2 + weight


def test_regressor_is_the_machine_s_dynamics(generic):
    """Bodies and closures against Lagrange's equation written by hand."""
    q, v, a = generic.random_states(30, 1)
    found = generic.full_regressor(q, v, a)[:, 0, :] @ np.concatenate([generic.prior, [0.0, 0.0]])
    assert found == pytest.approx(torque(q, v, a)[:, 0], rel=1e-7, abs=1e-8)


def test_motion_of_one_axis_is_drawn_in_its_phase_plane(generic):
    series = excitation.Series(1.0, np.zeros((1, 4)), np.array([[0.5, 0.0, 0.1, 0.0]]))
    best = excitation.Search("random", 1.0, 1, excitation.Excitation(generic.start, series))
    figure = figures.excitation(SimpleNamespace(machine=generic, best=best))
    plane = figure.axes[0]
    assert plane.get_title() == "phase plane"
    assert np.ptp(plane.lines[0].get_ydata()) > 1e3  # [mm/s]


@pytest.mark.slow
def test_base_parameters_predict_another_motion(generic):
    """Planted parameters 20 % off the drawn ones: force within 1.1 times the noise, where the drawn ones are far off."""
    base, by_qr, angle = study.structure(generic, 0, states=60)
    assert len(base.kept) == len(by_qr.kept) < len(generic.names)
    assert base.gap > 1e5
    assert angle < 1e-6
    rigid = generic.truth(4)
    truth = np.concatenate([rigid, generic.coulomb, generic.viscous])
    moves = [study.Moving(excitation.random(generic, base.kept, seed)) for seed in (1, 2)]
    data, held_out = (
        measurement.measure(generic, measurement.ideal(generic, rigid, move), seed)
        for seed, move in enumerate(moves)
    )
    found = fit(data, base, generic.axes)
    left = held_out.force - held_out.regressor[:, list(base.kept)] @ found.values
    planted = held_out.force - held_out.regressor @ truth
    drawn = held_out.force - held_out.regressor @ np.concatenate([generic.prior, truth[-2:]])
    assert np.linalg.norm(left) < 1.2 * np.linalg.norm(planted)
    assert np.linalg.norm(left) < 0.2 * np.linalg.norm(drawn)
