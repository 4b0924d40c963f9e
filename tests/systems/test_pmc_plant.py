"""The PepperMill-Carrier as MultibodyPlant: its description, and equality with the closed form."""

from dataclasses import replace

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant
from pydrake.systems.analysis import Simulator

from gapscope.models.pmc import constants, description, dynamics, kinematics, limits, simulation
from gapscope.models.pmc.cycle import LameCycle, Placement
from gapscope.models.pmc.parameters import Counterweight, PMCParameters
from gapscope.systems import closures, pmc_plant

# The rope is not a body of the plant.
FREE = replace(PMCParameters(), counterweight=Counterweight(mass=0.0), payload=0.3)


def random_states(n, seed, p=FREE):
    rng = np.random.default_rng(seed)
    safe, g = limits.elevation_limits(p.geometry), p.geometry
    alpha = rng.uniform(safe.safe_min, safe.safe_max, (n, 2))
    d = rng.uniform(g.carriage_min, g.carriage_max, (n, 2))
    joints = np.column_stack([d, alpha[:, 0], np.pi / 2 - alpha[:, 1]])
    return joints, rng.normal(size=(n, 4)) * [0.4, 0.4, 1.5, 1.5]


def largest_difference(p, c, n=50):
    plant = pmc_plant.ProjectedPlant(p)
    assert plant.plant.num_velocities() == 10  # less a loop of rank 6: four freedoms
    rng = np.random.default_rng(62)
    worst = 0.0
    for w, v in zip(*random_states(n, seed=61, p=p)):
        force = rng.normal(size=4) * [100.0, 100.0, 5.0, 5.0]
        projected = plant.project(w, v)
        assert projected.rank == 6
        ours = np.array(dynamics.acceleration(w, v, force, c))
        difference = np.abs(ours - projected.acceleration(force)).max()
        worst = max(worst, difference / np.abs(ours).max())
    return worst


def test_closed_form_equals_the_projected_plant():
    """Relative 1e-10 asked; eps times the condition of the closure allows 1e-12."""
    assert largest_difference(FREE, constants.of(FREE)) < 1e-11


def test_unequal_links_equal_the_projected_plant():
    geometry = replace(FREE.geometry, proximal=0.28, distal=0.33)
    p = replace(FREE, geometry=geometry, distal_centre=0.12)
    assert largest_difference(p, constants.of(p), n=10) < 1e-11


@pytest.mark.parametrize("field", ["wrist_mass", "rod_inertia", "mill_inertia", "screw_damping"])
def test_one_per_cent_is_seen(field):
    c = constants.of(FREE)
    wrong = c._replace(**{field: 1.01 * getattr(c, field)})
    assert largest_difference(FREE, wrong, n=5) > 1e-6


def test_laws_take_autodiff():
    """The gradient of the acceleration by a joint equals central differences."""
    from pydrake.autodiffutils import InitializeAutoDiff

    c = constants.of(PMCParameters())
    (w,), (v,) = random_states(1, seed=63)
    force = np.array([10.0, -5.0, 1.0, -2.0])
    derivatives = dynamics.acceleration(InitializeAutoDiff(w).ravel(), v, force, c)
    step = 1e-6
    for j in range(4):
        shift = np.eye(4)[j] * step
        ahead, behind = (
            np.array(dynamics.acceleration(w + s, v, force, c)) for s in (shift, -shift)
        )
        exact = np.array([a.derivatives()[j] for a in derivatives])
        assert (ahead - behind) / (2.0 * step) == pytest.approx(exact, rel=1e-5, abs=1e-4)


def test_forward_kinematics_of_the_plant():
    """The PM of the tree stands at the pose of the forward analysis, turned by -phi about z."""
    plant = pmc_plant.ProjectedPlant(FREE)
    (w,), _ = random_states(1, seed=64)
    pose = kinematics.forward(w, FREE.geometry)
    plant.project(w, np.zeros(4))
    X_WB = plant.plant.EvalBodyPoseInWorld(plant.context, plant.plant.GetBodyByName("pepper_mill"))
    assert X_WB.translation() == pytest.approx(pose[:3], abs=1e-12)
    x_axis = X_WB.rotation().matrix()[:, 0]
    assert x_axis == pytest.approx([np.cos(pose[3]), -np.sin(pose[3]), 0.0], abs=1e-10)
    assert pmc_plant.closure_error(plant.plant, plant.context) < 1e-12


def test_packaged_sdf_is_the_prototype():
    """``pmc.sdf`` is what the description writes, and Drake finds it through package.xml."""
    text = (pmc_plant.FOLDER / "pmc.sdf").read_text()
    assert text == description.sdf(PMCParameters())
    plant = MultibodyPlant(0.0)
    parser = Parser(plant)
    parser.package_map().AddPackageXml(str(pmc_plant.FOLDER.parent / "package.xml"))
    parser.AddModels(url="package://gapscope_models/pmc/pmc.sdf")
    plant.Finalize()
    assert plant.num_actuators() == 4


def closure_over_a_cycle(time_step, until):
    """Largest closure and tracking errors while computed torque moves the discrete plant."""
    place = Placement(x=0.299, y=0.299, z=-0.22, phi=FREE.geometry.centre_angle, direction=0.8)
    reference = simulation.sample_cycle(LameCycle(placement=place, time=1.0), FREE)
    c = constants.of(FREE)
    plant = pmc_plant.discrete_plant(replace(FREE, torque_limit=100.0), time_step)
    simulator = Simulator(plant)
    context = simulator.get_mutable_context()
    plant.SetPositions(context, pmc_plant.tree_positions(reference.joints[0], plant, FREE.geometry))
    driven = [plant.GetJointByName(name) for name in pmc_plant.DRIVEN]
    order = np.argsort([joint.velocity_start() for joint in driven])
    worst = tracking = 0.0
    for k, t in enumerate(reference.time):
        if t >= until:
            break
        q, v = plant.GetPositions(context), plant.GetVelocities(context)
        w = np.array([q[joint.position_start()] for joint in driven])
        rate = np.array([v[joint.velocity_start()] for joint in driven])
        asked = (
            reference.joint_accelerations[k]
            + 400.0 * (reference.joints[k] - w)
            + 40.0 * (reference.joint_rates[k] - rate)
        )
        force = np.array(dynamics.inverse_dynamics(w, rate, asked, c))
        plant.get_actuation_input_port().FixValue(context, force[order])
        simulator.AdvanceTo(t + 1e-3)
        worst = max(worst, pmc_plant.closure_error(plant, context))
        tracking = max(tracking, np.abs(w - reference.joints[k]).max())
    return worst, tracking


def test_sap_plant_keeps_the_loop_closed():
    """Asked: below 2 um at 1 ms and 0.1 um at 0.2 ms; measured 0.1 and 0.004 over a fast cycle.

    The error is of second order in the step: 25 times smaller at a fifth of it.
    """
    coarse, tracking = closure_over_a_cycle(1e-3, until=1.0)
    fine, _ = closure_over_a_cycle(2e-4, until=1.0)
    assert tracking < 1e-3
    assert coarse < 5e-7
    assert fine < 2e-8
    assert 15.0 < coarse / fine < 40.0


def test_unknown_closures_are_refused(tmp_path):
    path = tmp_path / "closures.yaml"
    path.write_text("- {type: weld, body_a: a, body_c: b}")
    with pytest.raises(ValueError, match="unknown key 'body_c'"):
        closures.load(path)
    with pytest.raises(ValueError, match="expected weld or ball"):
        closures.Closure(type="glue", body_a="a", body_b="b")
