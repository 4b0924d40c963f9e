"""Physics of the blind machine's C-drive, and its agreement with the open log set without effect."""

import os
from pathlib import Path

import numpy as np
import pytest

from gapscope.analysis.blind_machine import c_drive, drive_logset, logset, strength
from gapscope.analysis.blind_machine.case import NONE, Case
from gapscope.analysis.blind_machine.motion import out_and_back

LSB = 2 * np.pi / 2**13


def case(machine=None, **changes):
    nominal = c_drive.Machine()
    return Case(
        seed=0,
        index=0,
        kind=NONE,
        answer=(),
        cause=(),
        nominal=nominal,
        machine=machine or nominal,
        partial={},
        noise_seed=1,
        **changes,
    )


def coasting(torque, samples=200, machine=None, command=None):
    """True screw angles (n FINE, 2) with the loop cut: a bias torque per screw and no gains."""
    free = c_drive.Machine(bias_screw=torque) if machine is None else machine
    still = np.zeros((samples, 2))
    controller = drive_logset.STIFF["pd"]._replace(kp=(0.0, 0.0), kd=(0.0, 0.0))
    program = c_drive.Program(still, still, still, still[:, 0], still[:, 0], 0.0)
    return c_drive.run(free, controller, program)[2]


def test_inertia_is_the_thesis_matrix():
    """M (5.2) from the collar and two screws: (2.6a) with lead 60 mm/rev, to the printed digits."""
    m = c_drive.Machine()
    per_screw = m.mass / (2 * c_drive.TURNS) ** 2
    m11 = m.rotor_inertia + m.turning_inertia / 4 + per_screw
    m12 = m.turning_inertia / 4 - per_screw
    assert (m11, m12) == pytest.approx((2.6312e-3, 1.8797e-3), abs=5e-8)


@pytest.mark.parametrize(("torque", "mode"), [((0.1, -0.1), 0), ((0.1, 0.1), 1)])
def test_constant_torque_gives_the_closed_form(torque, mode):
    """e psi'' + g psi' = tau of one mode: psi = tau/g (t - T (1 - exp(-t/T))), T = e/g."""
    inertia = (0.7515e-3, 4.5109e-3)[mode]
    damping = (0.004148 + 0.002792, 0.004148)[mode]
    t = 1e-4 * np.arange(2000)
    time = inertia / damping
    expected = 0.1 / damping * (t - time * (1 - np.exp(-t / time)))
    got = coasting(torque)[:, 0]
    # Second order: an error of a few (h/T)^2 of the answer, h = 20 us.
    assert np.abs(got - expected).max() < 4 * (20e-6 / time) ** 2 * expected.max()


def test_stiff_nuts_approach_rigid_ones():
    torque = (0.1, 0.03)
    rigid = coasting(torque)
    stiff = c_drive.Machine(bias_screw=torque, stiffness=2000.0, coupling_damping=0.1)
    # Static wind-up of a nut is torque over stiffness; the rest of the motion must agree.
    assert np.abs(coasting(torque, machine=stiff) - rigid).max() < 4 * 0.1 / 2000.0


def test_dry_friction_holds_a_smaller_torque_exactly():
    even = (0.2, 0.2)
    stuck = c_drive.Machine(bias_screw=(0.15, -0.19), coulomb=(even, even, (0.0, 0.0)))
    # Gauss-Seidel leaves a creep far below a count; a smoothed sign would drift by radians.
    assert np.abs(coasting(None, machine=stuck)).max() < 1e-6
    slipping = c_drive.Machine(bias_screw=(0.25, -0.25), coulomb=(even, even, (0.0, 0.0)))
    free = coasting((0.05, -0.05))
    assert coasting(None, machine=slipping)[-1] == pytest.approx(free[-1], rel=1e-3)


def test_presliding_springs_back():
    """Below the yield of its first element, Maxwell slip is a spring: released, it returns."""
    even = (0.4, 0.4)
    m = c_drive.Machine(coulomb=(even, even, (0.0, 0.0)), presliding=1.0, bias_screw=(0.05, -0.05))
    stiffness = sum(0.4 / 4 / (j / 4) for j in (1, 2, 3, 4))  # shares over reaches
    angle = coasting(None, samples=600, machine=m)[:, 0]
    inertia = 0.7515e-3
    period = 2 * np.pi * np.sqrt(inertia / stiffness)
    peaks = np.flatnonzero((angle[1:-1] > angle[:-2]) & (angle[1:-1] >= angle[2:])) * 1e-4
    assert np.mean(np.diff(peaks)) == pytest.approx(period, rel=0.01)
    assert angle.mean() == pytest.approx(0.05 / stiffness, rel=0.1)


def test_a_gap_lets_the_screw_turn_alone():
    m = c_drive.Machine(gap=(0.2, 0.2), stiffness=4000.0, bias_screw=(0.1, 0.1))
    angle = coasting(None, samples=10, machine=m)[:, 0]
    t = 1e-4 * np.arange(len(angle))
    inside = angle < 0.09
    expected = 0.5 * 0.1 / m.rotor_inertia * t**2
    # Only the bearing's viscous torque differs: a relative beta t / (3 I_h) below 3 %.
    assert angle[inside] == pytest.approx(expected[inside], rel=0.03, abs=1e-6)


def test_a_rest_machine_stays_where_it_is():
    assert np.all(coasting((0.0, 0.0)) == 0.0)


@pytest.mark.parametrize("rate", [1.0, 2.0])
def test_motion_ends_at_rest_and_repeats(rate):
    t, stroke, curvature = out_and_back(rate, 3)
    n = len(t) // 3
    assert stroke.min() == 0.0
    assert stroke.max() == pytest.approx(1.0)
    assert stroke[:n] == pytest.approx(stroke[n : 2 * n], abs=1e-9)
    numeric = np.gradient(np.gradient(stroke, t), t)
    assert curvature[5:-5] == pytest.approx(numeric[5:-5], abs=5e-3 * np.abs(curvature).max())


def test_without_effect_or_nuisance_equals_the_open_set():
    """Differences from gap/open/none repeat like that machine's own cycles: nothing systematic."""
    data = os.environ.get("GAPSCOPE_DATA")
    folder = Path(data or "").parent / "gap" / "open" / "none"
    if not data or not folder.is_dir():
        pytest.skip("set GAPSCOPE_DATA to the shared data folder; gap/open is beside it")
    c = case()
    tables = logset.simulate(c, c.nominal)
    opened = [
        np.loadtxt(folder / f"run{number}.csv", delimiter=",", skiprows=1) for number in range(1, 7)
    ]
    floor = strength.floor(opened, drive_logset.SIGNALS)
    for mine, theirs in zip(tables, opened):
        n = len(mine) // 3
        assert mine[:, 1:3] == pytest.approx(theirs[:, 1:3], abs=6e-7)  # printed to 1e-6
        gap = (mine - theirs)[:n, 3:7]
        # Two independent realisations differ by sqrt(2) floors; a run's floor may be 2.2 times
        # the pooled one (the modelled controllers chatter most).
        assert np.all(gap.std(axis=0) < 1.5 * np.sqrt(2) * np.maximum(floor, floor * 1.5))
        assert np.all(np.abs(gap[:, :2].mean(axis=0)) < 0.05 * LSB)
