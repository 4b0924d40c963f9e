"""Closed-form kinematics and dynamics of the MM3A against a MultibodyPlant and themselves."""

from importlib.resources import files

import numpy as np
import pytest
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import JacobianWrtVariable

from gapscope.models.mm3a import dynamics, kinematics
from gapscope.models.mm3a.arm import STANDARD_GRAVITY, Arm, gravity_in_base
from gapscope.models.mm3a.sdf import sdf
from gapscope.systems.mm3a.plant import add_arm

ARM = Arm()
TOLERANCE = 1e-12  # relative to the largest element: some thousand eps, room for Drake's recursion


def random_arm(rng):
    """Another arm, so that no term can hide behind a default that happens to be small."""
    values = {
        name: value * rng.uniform(0.9, 1.1)
        for name, value in vars(ARM).items()
        if name.startswith(("shoulder", "forearm", "centre", "mass"))
    }
    for link in "123":
        a, b, c = rng.uniform(1e-9, 1e-6, 3)  # integrals of x^2, y^2, z^2 over the mass
        values |= {
            f"inertia_{link}x": b + c,
            f"inertia_{link}y": a + c,
            f"inertia_{link}z": a + b,
        }
    return Arm(**values)


def random_joints(rng, arm=ARM):
    return rng.uniform(arm.lower, arm.upper)


@pytest.fixture(params=range(20))
def case(request):
    """A random arm, tilt and state, with the plant's context set to them."""
    rng = np.random.default_rng(request.param)
    arm = ARM if request.param == 0 else random_arm(rng)
    theta, psi = rng.uniform(-np.pi, np.pi, 2)
    plant = MultibodyPlant(0.0)
    add_arm(plant, arm, theta, psi)
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q, v = random_joints(rng, arm), rng.uniform(-3.0, 3.0, 3)
    plant.SetPositions(context, q)
    plant.SetVelocities(context, v)
    return plant, context, arm, gravity_in_base(theta, psi), q, v, rng


def assert_equal(actual, expected):
    actual, expected = np.array(actual, dtype=float), np.array(expected, dtype=float)
    np.testing.assert_allclose(actual, expected, rtol=0.0, atol=TOLERANCE * np.abs(expected).max())


def test_mass_matrix_of_the_plant_is_the_printed_diagonal(case):
    plant, context, arm, _, q, _, _ = case
    assert_equal(np.diag(dynamics.mass_diagonal(q, arm)), plant.CalcMassMatrix(context))


def test_gravity_load_on_a_tilted_base(case):
    plant, context, arm, gravity, q, _, _ = case
    expected = -plant.CalcGravityGeneralizedForces(context)
    assert_equal(dynamics.gravity_load(q, gravity, arm), expected)


def test_coriolis_matrix_times_rate_is_the_bias_of_the_plant(case):
    plant, context, arm, _, q, v, _ = case
    assert_equal(np.array(dynamics.coriolis_matrix(q, v, arm)) @ v, plant.CalcBiasTerm(context))


def test_every_element_of_the_coriolis_matrix_is_a_christoffel_sum_of_the_plant(case):
    """(A.19, A.20) on the mass matrix that Drake differentiates: not only the product C q'."""
    plant, _, arm, _, q, v, _ = case
    plant_ad = plant.ToAutoDiffXd()
    context = plant_ad.CreateDefaultContext()
    plant_ad.SetPositions(context, InitializeAutoDiff(q).ravel())
    by_q = ExtractGradient(plant_ad.CalcMassMatrix(context).reshape(9, 1)).reshape(3, 3, 3)
    christoffel = 0.5 * (by_q + by_q.transpose(0, 2, 1) - by_q.transpose(2, 1, 0))
    assert_equal(dynamics.coriolis_matrix(q, v, arm), christoffel @ v)


def test_inertia_rate_minus_twice_coriolis_is_skew(case):
    """Fails with C_32 as printed in (A.108)."""
    _, _, arm, _, q, v, _ = case
    h = 1e-6
    ahead = np.array(dynamics.mass_diagonal(q + h * v, arm))
    behind = np.array(dynamics.mass_diagonal(q - h * v, arm))
    matrix = np.diag((ahead - behind) / (2 * h)) - 2 * np.array(dynamics.coriolis_matrix(q, v, arm))
    # The central difference is exact to h^2 plus the rounding eps*M/h.
    np.testing.assert_allclose(matrix + matrix.T, 0.0, atol=1e-8 * np.abs(matrix).max())


def test_effort_is_the_inverse_dynamics_of_the_plant_with_a_force_on_the_tip(case):
    plant, context, arm, gravity, q, v, rng = case
    acceleration, force = rng.uniform(-5.0, 5.0, 3), rng.uniform(-0.05, 0.05, 3)
    base, tip = plant.GetFrameByName("base"), plant.GetFrameByName("link_3")
    J = plant.CalcJacobianTranslationalVelocity(
        context, JacobianWrtVariable.kV, tip, np.zeros(3), base, base
    )
    expected = (
        plant.CalcMassMatrix(context) @ acceleration
        + plant.CalcBiasTerm(context)
        - plant.CalcGravityGeneralizedForces(context)
        - J.T @ force
    )
    assert_equal(dynamics.effort(q, v, acceleration, gravity, force, arm), expected)


def test_tip_orientation_and_jacobians(case):
    plant, context, arm, _, q, _, _ = case
    base, tip = plant.GetFrameByName("base"), plant.GetFrameByName("link_3")
    X = tip.CalcPose(context, base)
    J = plant.CalcJacobianSpatialVelocity(
        context, JacobianWrtVariable.kV, tip, np.zeros(3), base, base
    )
    assert_equal(kinematics.tip(q, arm), X.translation())
    assert_equal(kinematics.tip_axes(q), X.rotation().matrix())
    assert_equal(kinematics.jacobian(q, arm), J[3:])
    assert_equal(kinematics.rotation_jacobian(q), J[:3])


def test_one_moving_joint_is_a_row_of_the_full_dynamics():
    rng = np.random.default_rng(1)
    for joint in range(3):
        q, gravity, force = random_joints(rng), rng.normal(size=3), rng.normal(size=3)
        rate, acceleration = np.zeros(3), np.zeros(3)
        rate[joint], acceleration[joint] = rng.normal(size=2)
        full = dynamics.effort(q, rate, acceleration, gravity, force, ARM)[joint]
        alone = dynamics.single_joint_effort(joint, acceleration[joint], q, gravity, force, ARM)
        assert alone == pytest.approx(full, rel=1e-14)


def test_a_small_motion_against_the_static_load_costs_its_work():
    """Virtual work: the load is the gradient of potential energy minus the work of the tip force."""
    rng = np.random.default_rng(2)
    q, force = random_joints(rng), rng.normal(size=3)
    load = dynamics.static_load(q, (0.0, 0.0, 0.0), force, ARM)
    for joint in range(3):
        step = np.eye(3)[joint] * 1e-6
        moved = np.subtract(kinematics.tip(q + step, ARM), kinematics.tip(q - step, ARM))
        assert load[joint] == pytest.approx(-force @ moved / 2e-6, rel=1e-8)


@pytest.mark.parametrize("backward", [False, True])
def test_inverse_kinematics_returns_every_reachable_posture(backward):
    """FK(IK(x)) = x and IK(FK(q)) = q over the whole joint range, on the branch q is on."""
    rng = np.random.default_rng(3)
    tested = 0
    while tested < 1000:
        q = random_joints(rng)
        reach = ARM.shoulder - (ARM.forearm + q[2]) * np.sin(q[1])
        if bool(reach < 0.0) is not backward:
            continue
        found = kinematics.inverse(kinematics.tip(q, ARM), ARM, backward)
        np.testing.assert_allclose(found, q, rtol=0.0, atol=1e-12)
        tested += 1


def test_solutions_reach_the_point_and_respect_the_limits():
    q = (0.9, np.pi / 6, 0.010)  # tip behind the axis of joint 1: reached backward
    point = kinematics.tip(q, ARM)
    found = kinematics.solutions(point, ARM)
    assert any(np.allclose(q, candidate, atol=1e-12) for candidate in found)
    for candidate in found:
        np.testing.assert_allclose(kinematics.tip(candidate, ARM), point, atol=1e-15)
        assert kinematics.within_limits(candidate, ARM)
    assert kinematics.solutions((0.2, 0.0, 0.0), ARM) == []


def test_zero_position_is_figure_3_2():
    """At q = 0 the forearm points up over the axis of joint 2; at q2 = -pi/2 it points outward."""
    np.testing.assert_allclose(kinematics.tip((0, 0, 0), ARM), (ARM.shoulder, 0, ARM.forearm))
    outward = kinematics.tip((0, -np.pi / 2, 0), ARM)
    np.testing.assert_allclose(outward, (ARM.shoulder + ARM.forearm, 0, 0), atol=1e-17)


def test_lengths_reproduce_the_step_sizes_of_chapter_2():
    """5 nm per 1e-7 rad, 20 um and 15 um per 4e-4 rad of joints 1 and 2, at mid-travel."""
    middle = (0.0, -np.pi / 2, 0.006)
    rows = np.array(kinematics.jacobian(middle, ARM))
    lever_1, lever_2 = np.linalg.norm(rows[:, 0]), np.linalg.norm(rows[:, 1])
    assert lever_1 * 1e-7 == pytest.approx(5e-9, rel=1e-12)
    assert lever_1 * 4e-4 == pytest.approx(20e-6, rel=1e-12)
    assert lever_2 * 4e-4 == pytest.approx(15e-6, rel=1e-12)


def test_moment_about_joint_2_grows_like_the_printed_load_terms():
    """Mean printed |d_i| of Fig. 5.6: (3.83 + 8.15)/2 retracted, (23.94 + 19.40)/2 extended."""
    ratio = dynamics.moment_2((0, 0, 0.012), ARM) / dynamics.moment_2((0, 0, 0.0), ARM)
    assert ratio == pytest.approx((23.94 + 19.40) / (3.83 + 8.15), rel=0.02)


def test_tilt_of_section_4_1_1():
    """theta = -pi/2 lays z_0 horizontal: neither joint 2 nor joint 3 carries weight (Fig. 4.2a)."""
    q = (0.0, -0.7, 0.004)
    load = dynamics.gravity_load(q, gravity_in_base(-np.pi / 2, 0.0), ARM)
    assert abs(load[1]) < 1e-17
    assert abs(load[2]) < 1e-17
    theta, psi = 0.4, -0.3
    load = dynamics.gravity_load(q, gravity_in_base(theta, psi), ARM)
    zeta = psi - q[1]
    weight = STANDARD_GRAVITY * np.cos(theta)
    assert load[1] == pytest.approx(dynamics.moment_2(q, ARM) * weight * np.sin(zeta), rel=1e-14)
    assert load[2] == pytest.approx(ARM.mass_3 * weight * np.cos(zeta), rel=1e-14)


def test_shipped_sdf_is_the_default_arm():
    shipped = files("gapscope.models.mm3a").joinpath("mm3a.sdf").read_text()
    assert shipped == sdf(ARM)


def test_arm_refuses_impossible_constants():
    with pytest.raises(ValueError, match=r"mass_2 is -1\.0; expected a positive number"):
        Arm(mass_2=-1.0)
    with pytest.raises(ValueError, match=r"joint 3 ranges from 0\.02 to 0\.012"):
        Arm(lower_3=0.02)
    with pytest.raises(ValueError, match="inertias of link 1"):
        Arm(inertia_1x=1.0)
