"""State space of the C-drive: Friedlaender 2015, sections 4.3 to 4.5."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from gapscope.models import c_drive, drive
from gapscope.models import c_drive_state_space as ss
from gapscope.models.c_drive import CDriveParameters

P = CDriveParameters()
EPS = np.finfo(float).eps


def test_modes_are_the_eigenvalues_of_M_and_D():
    modes = ss.collar_modes(P)
    M, D = c_drive.inertia_matrix(P), c_drive.damping_matrix(P)
    np.testing.assert_allclose(np.sort(modes.inertia), np.linalg.eigvalsh(M), rtol=1e-13)
    np.testing.assert_allclose(np.sort(modes.damping), np.linalg.eigvalsh(D), rtol=1e-13)


def test_collar_directions_are_decoupled_as_in_eq_4_3b():
    J, J_inverse = c_drive.jacobian(P.lead), c_drive.inverse_jacobian(P.lead)
    for matrix in (c_drive.inertia_matrix(P), c_drive.damping_matrix(P)):
        similar = J @ matrix @ J_inverse
        assert np.abs(similar - np.diag(np.diag(similar))).max() < 4 * EPS * np.abs(matrix).max()


def test_state_spaces_are_the_equation_of_motion():
    """y'' from both forms equals M^-1 (tau - D psi') at a random state."""
    rng = np.random.default_rng(1)
    angle, rate, torque = rng.normal(size=(3, 2))
    M, D = c_drive.inertia_matrix(P), c_drive.damping_matrix(P)
    wanted = np.linalg.solve(M, torque - D @ rate)
    u, x = ss.to_input(P) @ torque, ss.to_sigma(P) @ rate
    two, four = ss.two_dimensional(P), ss.four_dimensional(P)
    np.testing.assert_allclose(two.C @ x, rate, rtol=1e-13)
    np.testing.assert_allclose(two.C @ (two.A @ x + two.B @ u), wanted, rtol=1e-12)
    state = np.concatenate([ss.to_sigma(P) @ angle, x / ss.collar_modes(P).rate])
    derivative = four.A @ state + four.B @ u
    np.testing.assert_allclose(four.C @ state, angle, rtol=1e-13)
    np.testing.assert_allclose(four.C @ derivative, rate, rtol=1e-12)
    np.testing.assert_allclose(four.C @ four.A @ derivative, wanted, rtol=1e-12)


def test_controllability_matrices_are_eqs_4_12_and_4_16():
    H = np.diag(ss.collar_modes(P).rate)
    one, zero = np.eye(2), np.zeros((2, 2))
    np.testing.assert_array_equal(
        ss.controllability_matrix(ss.two_dimensional(P)), np.hstack([one, -H])
    )
    np.testing.assert_allclose(
        ss.controllability_matrix(ss.four_dimensional(P)),
        np.block([[zero, one, -H, H @ H], [np.linalg.inv(H), -one, H, -H @ H]]),
        rtol=1e-14,
    )


def test_observability_matrix_is_eq_4_18_with_its_signs_corrected():
    H, Y, zero = np.diag(ss.collar_modes(P).rate), ss.output_matrix(P), np.zeros((2, 2))
    np.testing.assert_allclose(
        ss.observability_matrix(ss.four_dimensional(P)),
        np.block([[Y, zero], [zero, Y @ H], [zero, -Y @ H @ H], [zero, Y @ H @ H @ H]]),
        rtol=1e-13,
    )


def test_exponent_of_eq_4_19_is_minus_three_halves():
    modes = ss.collar_modes(P)
    right = 2.0 * np.pi / P.lead * np.array([[1.0, 1.0], [-1.0, 1.0]]) * modes.damping
    YH = ss.output_matrix(P) @ np.diag(modes.rate)
    np.testing.assert_allclose(YH, right * modes.inertia**-1.5, rtol=1e-13)
    for misprint in (-2.0 / 3.0, -0.5):
        assert np.all(np.abs(YH / (right * modes.inertia**misprint) - 1.0) > 1.0)


@pytest.mark.parametrize("form", [ss.two_dimensional, ss.four_dimensional])
def test_the_c_drive_is_completely_controllable_and_observable(form):
    assert ss.is_controllable(form(P))
    assert ss.is_observable(form(P))


def test_a_drive_seen_or_driven_through_one_direction_only_is_not():
    system = ss.four_dimensional(P)
    one_direction = np.diag([1.0, 0.0])
    assert not ss.is_controllable(system._replace(B=system.B @ one_direction))
    Y = ss.output_matrix(P) @ one_direction
    assert not ss.is_observable(system._replace(C=np.hstack([Y, np.zeros((2, 2))])))


def test_four_dimensions_need_friction_in_both_directions():
    with pytest.raises(ValueError, match="viscous friction in both directions"):
        ss.four_dimensional(replace(P, beta=0.0))


def test_response_is_the_matrix_exponential_of_the_four_dimensional_form():
    angle, rate, torque, t = [0.3, -0.7], [2.0, 5.0], [0.4, -1.1], 0.13
    system, h = ss.four_dimensional(P), ss.collar_modes(P).rate
    u = ss.to_input(P) @ torque
    augmented = np.block([[system.A, (system.B @ u)[:, None]], [np.zeros((1, 5))]])
    start = np.concatenate([ss.to_sigma(P) @ angle, ss.to_sigma(P) @ rate / h, [1.0]])
    end = (expm(augmented * t) @ start)[:4]
    got_angle, got_rate = ss.held_torque_response(P, angle, rate, torque, t)
    np.testing.assert_allclose(got_angle, system.C @ end, rtol=1e-12)
    np.testing.assert_allclose(got_rate, system.C @ system.A @ end, rtol=1e-12)


def test_response_without_friction_is_uniform_acceleration():
    free = replace(P, beta=0.0, gamma=0.0)
    torque, t = np.array([0.4, -1.1]), np.array([0.0, 0.1, 0.2])
    a = np.linalg.solve(c_drive.inertia_matrix(free), torque)
    angle, rate = ss.held_torque_response(free, [0.0, 0.0], [0.0, 0.0], torque, t)
    np.testing.assert_allclose(angle, 0.5 * np.multiply.outer(t**2, a), rtol=1e-12)
    np.testing.assert_allclose(rate, np.multiply.outer(t, a), rtol=1e-12)


def test_simulation_follows_the_analytic_response():
    """Error of ODE4 over n steps of h: below n (h_max dt)^5 / 120 of the change in rate."""
    dt, steps = 1e-3, 400
    plant, work = (
        drive.ideal_drive(
            c_drive.inertia_matrix(P), c_drive.ELEMENT_MAP, [P.beta, P.beta, P.gamma / 2], 0.5
        ),
        drive.work_arrays(2),
    )
    rng = np.random.default_rng(2)
    q, v = np.array([0.1, -0.2]), np.array([3.0, 1.0])
    angle, rate = q.copy(), v.copy()
    for k in range(steps):
        if k % 50 == 0:
            torque = rng.normal(size=2)
        drive.ode4_step(q, v, np.zeros(3), torque, k * dt, dt, plant, work)
        angle, rate = ss.held_torque_response(P, angle, rate, torque, dt)
    h = ss.collar_modes(P).rate.max()
    bound = (
        steps * (h * dt) ** 5 / 120.0 * np.abs(rate).max() * 10 + 100 * EPS * np.abs(angle).max()
    )
    np.testing.assert_allclose(v, rate, rtol=0, atol=bound)
    np.testing.assert_allclose(q, angle, rtol=0, atol=bound)
