"""The prototype's flaws: compliance from the loads, calibration through the encoders."""

from dataclasses import replace

import numpy as np
import pytest

from gapscope.models.pmc import constants, dynamics, kinematics, prototype, simulation
from gapscope.models.pmc.controllers import CONTROLLERS
from gapscope.models.pmc.cycle import LameCycle, Placement
from gapscope.models.pmc.parameters import Counterweight, PMCParameters
from gapscope.models.pmc.prototype import PrototypeEffects

from .sampling import working_joints

PROTOTYPE = PMCParameters()


def test_wrist_loads_carry_the_weight():
    """At rest the limbs together carry wrists and PM less the rope's pull, equally under the pulley."""
    still = np.zeros(4)
    w = np.array([0.299, 0.299, 0.2, np.pi / 2 - 0.2])
    loads = dynamics.wrist_loads(w, still, still, constants.of(PROTOTYPE))
    p = PROTOTYPE
    weight = 2.0 * p.wrist_mass + p.pepper_mill_mass - p.counterweight.mass
    assert sum(loads) == pytest.approx(9.81 * weight)
    assert loads[0] == pytest.approx(loads[1])


def test_wrist_loads_are_what_the_links_below_do_not_carry():
    """Without mass in the links the drive torques at rest are g times the wrist loads."""
    p = replace(PROTOTYPE, counterweight=Counterweight(mass=0.0))
    c = constants.of(p)._replace(crank_moment=0.0, rod_mass=0.0)
    still = np.zeros(4)
    for w in working_joints(50, seed=71):
        pose = kinematics.forward(w, p.geometry)
        rates = kinematics.jacobian(pose, w, p.geometry)
        pitch = p.geometry.pitch
        g1 = rates[2, 2] + pitch * rates[3, 2]
        g2 = rates[2, 3] - pitch * rates[3, 3]
        force = dynamics.inverse_dynamics(w, still, still, c)
        loads = dynamics.wrist_loads(w, still, still, c)
        assert (force[2], force[3]) == pytest.approx((g1 * loads[0], g2 * loads[1]), abs=1e-9)


def test_deflection_is_the_gradient_of_the_compliant_energy():
    """Castigliano: the wrists sink by the derivative of the links' strain energy by the load."""
    effects = PrototypeEffects()
    w = working_joints(1, seed=72)[0]
    loads = (12.0, -7.0)
    pose = kinematics.forward(w, PROTOTYPE.geometry)
    alpha1, beta1, alpha2, beta2 = kinematics.link_elevations(pose, w, PROTOTYPE.geometry)

    def energy(load, alpha, beta):
        axial = load / np.sin(beta)
        bending = axial * np.sin(beta - alpha)
        return 0.5 * (effects.joint_compliance * axial**2 + effects.link_compliance * bending**2)

    sink = [
        (energy(f + 1e-3, a, b) - energy(f - 1e-3, a, b)) / 2e-3
        for f, a, b in zip(loads, (alpha1, alpha2), (beta1, beta2))
    ]
    dz, dphi = prototype.deflection(w, loads, effects, PROTOTYPE)
    assert dz == pytest.approx(-0.5 * sum(sink))
    assert dphi == pytest.approx(-0.5 * (sink[0] - sink[1]) / PROTOTYPE.geometry.pitch)


def test_calibration_offset_turns_the_gripper_by_the_transmission():
    """At rest one drive off by delta turns the PM by g/(2p) delta: 47 times as far."""
    place = Placement(
        x=0.3, y=0.3, z=-0.3, phi=PROTOTYPE.geometry.centre_angle, direction=0.25 * np.pi
    )
    exact = replace(PROTOTYPE, encoder_bits=0)
    reference = simulation.sample_cycle(LameCycle(placement=place), exact, cycles=0.02)
    delta = 1e-3
    off = simulation.run(reference, CONTROLLERS["ct"], exact, calibration=(delta, 0.0))
    turned = off.poses[0, 3] - reference.poses[0, 3]
    jacobian = kinematics.jacobian(reference.poses[0], reference.joints[0], exact.geometry)
    assert turned == pytest.approx(jacobian[3, 2] * delta, rel=0.01)
    assert off.measured[0] == pytest.approx(np.zeros(4), abs=1e-9)
    assert np.abs(off.poses[:, 3] - off.poses[0, 3]).max() < 0.01


def test_no_effects_no_change():
    none = PrototypeEffects(
        joint_compliance=0.0, link_compliance=0.0, calibration1=0.0, calibration2=0.0
    )
    w = working_joints(10, seed=73)
    assert (prototype.deflection(w, (10.0, 5.0), none, PROTOTYPE) == 0.0).all()
    with pytest.raises(ValueError, match="link_compliance is -1"):
        PrototypeEffects(link_compliance=-1.0)


def test_unequal_gains_turn_the_gripper_by_the_difference_of_the_sags():
    """Drive 2 with half the gain sags by its torque over 52.5 instead of 105 N m/rad; g/(2p) turns it into rotation."""
    pose = kinematics.isotropic_pose(PROTOTYPE.geometry)
    w, still = kinematics.inverse(pose, PROTOTYPE.geometry), np.zeros(4)
    torque = dynamics.inverse_dynamics(w, still, still, constants.of(PROTOTYPE))[3]
    # Both motors of a C-drive turn with it; in its rotation each holds gain times motor angle.
    further = abs(torque) / (2.0 * 52.5) - abs(torque) / (2.0 * 105.0)
    expected = kinematics.jacobian(pose, w, PROTOTYPE.geometry)[3, 3] * further
    moved = prototype.unequal_sag(pose[None], PROTOTYPE)[0]
    assert abs(moved[3]) == pytest.approx(abs(expected), rel=0.02)
    assert moved[:2] == pytest.approx(np.zeros(2), abs=1e-6)
