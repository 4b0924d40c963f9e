"""Closed loops of the PepperMill-Carrier: what the thesis saw and what it recommends."""

from dataclasses import replace

import numpy as np
import pytest

from gapscope.models.pmc import constants, dynamics, simulation
from gapscope.models.pmc.controllers import CONTROLLERS, ComputedTorque, JointPD, controller
from gapscope.models.pmc.cycle import IndustryCycle, LameCycle, Placement
from gapscope.models.pmc.parameters import Counterweight, PMCParameters

PROTOTYPE = PMCParameters()
PLACE = Placement(
    x=0.299, y=0.299, z=-0.2229, phi=PROTOTYPE.geometry.centre_angle, direction=0.75 * np.pi
)
INDUSTRY = simulation.sample_cycle(IndustryCycle(placement=PLACE), PROTOTYPE)
SMOOTH = simulation.sample_cycle(LameCycle(placement=PLACE), PROTOTYPE)


def errors(run):
    return np.abs(run.poses - run.reference.poses).max(axis=0)


@pytest.mark.parametrize("name", ["ct", "ra"])
@pytest.mark.parametrize("reference", [INDUSTRY, SMOOTH])
def test_model_based_control_tracks_what_task_space_pd_does_not(name, reference):
    """Chapter 6 recommends resolved acceleration: rotation error falls by more than ten times."""
    ts = errors(simulation.run(reference, CONTROLLERS["ts"], PROTOTYPE))
    modelled = errors(simulation.run(reference, CONTROLLERS[name], PROTOTYPE))
    assert modelled[3] < 0.1 * ts[3]
    assert modelled[2] < 0.1 * ts[2]


def test_exact_model_errs_by_the_sample_only():
    """Without quantisation, limit and dry friction the error halves with the sample time."""
    exact = replace(
        PROTOTYPE,
        encoder_bits=0,
        torque_limit=100.0,
        counterweight=Counterweight(pulley_friction=0.0),
    )
    worst = []
    for dt in (1e-3, 5e-4):
        reference = simulation.sample_cycle(LameCycle(placement=PLACE), exact, sample_time=dt)
        fast = ComputedTorque(cutoff=0.5 / dt)
        worst.append(errors(simulation.run(reference, fast, exact)))
    ratio = worst[1] / worst[0]
    assert worst[0][:3].max() < 2e-4
    assert (np.abs(ratio - 0.5) < 0.1).all()


def test_without_counterweight_the_robot_sinks():
    light = replace(PROTOTYPE, counterweight=Counterweight(mass=0.0))
    for name in ("ts", "ra"):
        sunk = simulation.run(SMOOTH, CONTROLLERS[name], light)
        held = simulation.run(SMOOTH, CONTROLLERS[name], PROTOTYPE)
        assert np.nanmin((sunk.poses - SMOOTH.poses)[:, 2]) < -0.05
        assert errors(held)[2] < 0.012


def test_pd_starts_at_rest():
    """At the starting posture of a PD loop gains times sag balance the weight."""
    w = simulation.rest(SMOOTH, CONTROLLERS["pd"], PROTOTYPE)
    loop = controller(JointPD(), PROTOTYPE, SMOOTH.joints[0], 1e-3)
    torque = loop.kp @ loop.motor_map @ (SMOOTH.joints[0] - w)
    force = loop.motor_map.T @ torque
    still = np.zeros(4)
    acceleration = dynamics.acceleration(w, still, force, constants.of(PROTOTYPE))
    assert np.abs(acceleration).max() < 1e-8


def test_work_of_the_motors_is_the_energy_gained():
    """Without friction, over a whole cycle: held torques times the way of the motors; ODE4 errs by 1e-6."""
    free = replace(
        PROTOTYPE,
        encoder_bits=0,
        elbow_damping=0.0,
        wrist_damping=0.0,
        screw_damping=0.0,
        drive=replace(PROTOTYPE.drive, beta=0.0, gamma=0.0),
        counterweight=Counterweight(pulley_friction=0.0),
    )
    run = simulation.run(SMOOTH, CONTROLLERS["ra"], free)
    c = constants.of(free)
    motors = run.joints @ constants.motor_map(free.drive.lead).T
    work = np.cumsum((run.command[:-1] * np.diff(motors, axis=0)).sum(axis=1))
    w, v = tuple(run.joints.T), tuple(run.joint_rates.T)
    energy = dynamics.kinetic_energy(w, v, c) + dynamics.potential_energy(w, c)
    gained = energy[1:] - energy[0]
    assert np.ptp(energy) > 0.5
    assert (
        np.abs(work - gained).max()
        < 1e-6 * np.abs(run.command[:-1] * np.diff(motors, axis=0)).sum()
    )


def test_rope_stays_taut():
    run = simulation.run(INDUSTRY, CONTROLLERS["ra"], PROTOTYPE)
    assert run.rope_tension().min() > 0.0


def test_commands_keep_to_the_limit_and_measurements_to_the_counts():
    run = simulation.run(INDUSTRY, CONTROLLERS["ts"], PROTOTYPE)
    assert np.abs(run.command).max() <= PROTOTYPE.torque_limit
    counts = run.measured / (2.0 * np.pi / 2**13)
    assert np.abs(counts - counts.round()).max() < 1e-6


def test_unreachable_cycle_is_refused():
    far = replace(PLACE, z=-0.7)
    with pytest.raises(ValueError, match="leaves the reach"):
        simulation.sample_cycle(IndustryCycle(placement=far), PROTOTYPE)
