"""Predicting the motors' encoders: exact for the right model, white where only the counts are wrong."""

from dataclasses import replace

import numpy as np
import pytest

from gapscope.analysis.gap.floor import quantisation_floor
from gapscope.models import drive
from gapscope.models.pmc import constants, dynamics, prediction, simulation
from gapscope.models.pmc.controllers import CONTROLLERS
from gapscope.models.pmc.cycle import LameCycle, Placement
from gapscope.models.pmc.parameters import PMCParameters

from .sampling import working_joints

PROTOTYPE = PMCParameters()
PLACE = Placement(
    x=0.299, y=0.299, z=-0.2229, phi=PROTOTYPE.geometry.centre_angle, direction=0.75 * np.pi
)
DT, BANDWIDTH = 1e-3, 20.0
COUNT = 2.0 * np.pi / 2**13


def logged(robot, name="ra"):
    reference = simulation.sample_cycle(LameCycle(placement=PLACE), PROTOTYPE, cycles=0.25)
    return simulation.run(reference, CONTROLLERS[name], robot)


def residual(run, carrier, substeps=1):
    out = np.empty_like(run.measured)
    prediction.predict(run.measured, run.command, carrier, DT, substeps, BANDWIDTH, out)
    return out


def test_right_model_and_exact_encoders_leave_nothing():
    """Same laws by another way (friction in elements, motor coordinates): rounding only."""
    run = logged(replace(PROTOTYPE, encoder_bits=0))
    carrier = prediction.carrier(PROTOTYPE, run.reference.joints[0])
    assert np.abs(residual(run, carrier)).max() < 1e-10


@pytest.mark.parametrize("name", ["ra", "ts"])
def test_right_model_leaves_the_noise_of_the_counts(name):
    """lsb / sqrt(12) and what the observer adds; 5 % because counts are not white where the robot stands still."""
    run = logged(PROTOTYPE, name)
    left = residual(run, prediction.carrier(PROTOTYPE, run.reference.joints[0]))[50:]
    assert np.sqrt(np.mean(left**2)) == pytest.approx(
        quantisation_floor(COUNT, BANDWIDTH, DT), rel=0.05
    )


def test_one_per_cent_of_the_gripper_is_seen():
    run = logged(replace(PROTOTYPE, encoder_bits=0))
    carrier = prediction.carrier(replace(PROTOTYPE, payload=0.024), run.reference.joints[0])
    assert np.abs(residual(run, carrier)).max() > 1e-5


def test_first_gains_are_those_of_a_straight_line():
    """Through n samples the observer says where the least-squares line will be next."""
    rng = np.random.default_rng(5)
    seen = rng.normal(size=8)
    position = rate = 0.0
    for k, value in enumerate(seen):
        alpha, beta = prediction.first_gains(k, DT)
        error = value - position
        position, rate = position + alpha * error, rate + beta * error
        position += DT * rate
    slope, start = np.polyfit(np.arange(8), seen, 1)
    assert position == pytest.approx(start + 8.0 * slope)
    assert rate * DT == pytest.approx(slope)


def test_stiff_coupling_is_rigid():
    """Drive sides on a stiff spring move as one with their links: by 1e-4 rad of the motors at most."""
    run = logged(replace(PROTOTYPE, encoder_bits=0))
    carrier = prediction.carrier(PROTOTYPE, run.reference.joints[0])
    stiff = np.zeros((2, 5))
    stiff[:, drive.COUPLING_STIFFNESS], stiff[:, drive.COUPLING_DAMPING] = 2e5, 30.0
    c = carrier.constants
    split = carrier._replace(
        drive=carrier.drive._replace(coupling=stiff),
        constants=c._replace(crank_inertia=c.crank_inertia - carrier.drive_inertia),
    )
    assert np.abs(residual(run, split, substeps=8)).max() < 1e-4
    loose = split._replace(drive=split.drive._replace(coupling=stiff / 1000.0))
    assert np.abs(residual(run, loose)).max() > 1e-3


def test_dry_friction_of_elbows_and_wrists_takes_their_power():
    """Its joint forces take F |beta' - alpha'| + F |beta'| of both limbs, by the rates of differences."""
    carrier = prediction.carrier(PROTOTYPE, np.zeros(4))._replace(
        passive_dry=np.array([0.3, 0.2, 1e-9])
    )
    rng = np.random.default_rng(6)
    for w in working_joints(20, seed=81):
        v = rng.normal(size=4)
        taken = expected = 0.0
        for h, a, hr, ar in (
            (w[1], w[2], v[1], v[2]),
            (w[0], np.pi / 2 - w[3], v[0], -v[3]),
        ):
            on_reach, on_angle = prediction.passive_friction(h, a, hr, ar, carrier)
            taken += on_reach * hr + on_angle * ar

            def beta(t, h=h, a=a, hr=hr, ar=ar):
                return -np.arccos((h + t * hr - 0.3 * np.cos(a + t * ar)) / 0.3)

            rate = (beta(1e-6) - beta(-1e-6)) / 2e-6
            expected += 0.3 * abs(rate - ar) + 0.2 * abs(rate)
        assert taken == pytest.approx(expected, rel=1e-6)


def test_dry_friction_slows_the_joints_down():
    """The acceleration with friction differs by M^-1 of its joint forces, on the limbs' own joints."""
    w = working_joints(1, seed=82)[0]
    v = np.array([0.1, -0.2, 0.5, 0.4])
    base = prediction.carrier(PROTOTYPE, w)
    rough = base._replace(passive_dry=np.array([0.3, 0.2, 1e-3]))

    def power(carrier):
        out, motor = np.zeros(6), np.zeros((3, 4))
        both = np.append(w, w[2:]), np.append(v, v[2:])
        prediction.accelerations(*both, np.zeros(6), np.zeros(4), 0.0, carrier, motor, out)
        force = dynamics.inverse_dynamics(w, v, out[:4], constants.of(PROTOTYPE))
        return np.array(force) @ v

    assert power(rough) < power(base) - 0.05
