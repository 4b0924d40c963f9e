"""The exact sampled loop against an independent discretisation and against simulation."""

import numpy as np
import pytest
from scipy.linalg import expm

from gapscope.models import c_drive, drive, drive_kernels
from gapscope.models.c_drive import CDriveParameters
from gapscope.models.c_drive_controllers import PD, ComputedTorque, loop_controller
from gapscope.models.c_drive_state_space import collar_modes
from gapscope.models.loop_stability import dominant_mode, loop_matrix

P = CDriveParameters()
DT = 1e-3


def plant(delay=0.0, lag=0.0):
    machine = c_drive.drive(P)
    machine.shaft[:, drive.DELAY] = delay
    machine.shaft[:, drive.LAG] = lag
    return machine


def one_direction(pd, inertia, rate, delay, lag):
    """Spectral radius of a PD loop around e q'' + g q' = tau by the matrix exponential."""
    if lag > 0.0:
        A = np.array([[0.0, 1.0, 0.0], [0.0, -rate, 1.0 / inertia], [0.0, 0.0, -1.0 / lag]])
        B = np.array([0.0, 0.0, 1.0 / lag])
    else:
        A, B = np.array([[0.0, 1.0], [0.0, -rate]]), np.array([0.0, 1.0 / inertia])
    n, whole = len(A), int(delay // DT)

    def held(t):
        exponential = expm(np.block([[A, B[:, None]], [np.zeros((1, n + 1))]]) * t)
        return exponential[:n, :n], exponential[:n, n]

    (early, early_u), (late, late_u) = held(delay - whole * DT), held(DT - delay + whole * DT)
    size, decay = n + 2 + whole, np.exp(-pd.cutoff * DT)
    step = np.zeros((size, size))
    for i, state in enumerate(np.eye(size)):
        x, memory, past = state[:n], state[n], state[n + 1 :]
        error = -x[0]
        u = [pd.kp * error + pd.kd * pd.cutoff * (error - memory), *past]
        x = late @ (early @ x + early_u * u[whole + 1]) + late_u * u[whole]
        step[:, i] = [*x, error + decay * (memory - error), *u[:-1]]
    return np.abs(np.linalg.eigvals(step)).max()


def both_directions(pd, delay, lag):
    modes = collar_modes(P)
    return max(one_direction(pd, e, h, delay, lag) for e, h in zip(modes.inertia, modes.rate))


@pytest.mark.parametrize("delay", [0.0, 1e-3, 2e-3])
@pytest.mark.parametrize("kp", [20.0, 45.0, 150.0])
def test_whole_sample_delays_are_exact(kp, delay):
    """To the 1e-9 by which one Runge-Kutta step of 1 ms departs from the exponential."""
    controller = loop_controller(PD(kp=kp), P, DT)
    got = dominant_mode(plant(delay), controller, DT)
    assert got.radius == pytest.approx(both_directions(PD(kp=kp), delay, 0.0), abs=1e-9)
    assert got.growth == pytest.approx(np.log(got.radius) / DT)


def test_lag_and_part_delay_are_right_to_two_parts_in_a_thousand():
    """The amplifier delivers its mean over the sample; the exact shape moves the radius this much."""
    for kp in (20.0, 45.0, 60.0):
        got = dominant_mode(plant(0.5e-3, 0.6e-3), loop_controller(PD(kp=kp), P, DT), DT).radius
        assert got == pytest.approx(both_directions(PD(kp=kp), 0.5e-3, 0.6e-3), abs=2e-3)


@pytest.mark.parametrize("settings", [PD(), PD(ki=300.0), ComputedTorque()])
def test_matrix_moves_the_loop_as_the_simulation_does(settings):
    """Decay from an offset over 50 samples, the amplifier's lag on; rounding only.

    No delay: the simulation's delay line begins full of the first command, the matrix's with zeros.
    """
    machine, controller = plant(lag=0.6e-3), loop_controller(settings, P, DT)
    matrix = loop_matrix(machine, controller, DT)
    offset, samples = np.array([0.02, -0.01]), 50
    position, command, torque = (np.zeros((samples, 2)) for _ in range(3))
    position[0] = offset
    zero = np.zeros((samples, 2))
    memory = np.zeros((7, 2))
    drive_kernels.simulate(
        zero, zero, machine, controller, DT, 1, 0.0, memory, position, command, torque
    )
    state = np.zeros(len(matrix))
    state[:2] = offset
    for k in range(samples):
        np.testing.assert_allclose(position[k], state[:2], rtol=0, atol=1e-14)
        state = matrix @ state


def test_only_linear_feedback_loops_have_a_matrix():
    controller = loop_controller(PD(), P, DT)
    dry = plant()
    dry.element[0, drive.FORWARD] = 0.1
    with pytest.raises(ValueError, match="FORWARD"):
        loop_matrix(dry, controller, DT)
    with pytest.raises(ValueError, match="cascade"):
        loop_matrix(plant(), controller._replace(kind=drive_kernels.CASCADE), DT)
