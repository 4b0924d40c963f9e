r"""Linear state space of the C-drive: two and four dimensions (Friedlaender 2015, 4.3 to 4.5).

With :math:`E = J M J^{-1} = \mathrm{diag}(e)`, :math:`G = J D J^{-1} = \mathrm{diag}(g)` and
:math:`h_i = g_i / e_i` (4.3, 4.5), the collar's translation and rotation decouple:

1. :math:`\ddot\sigma + H \dot\sigma = u`, :math:`\sigma = \sqrt E w`, :math:`u = \sqrt E^{-1} J \tau`
   (4.4, 4.6);
2. two dimensions: :math:`x = \dot\sigma`, :math:`A = -H, B = 1, C = J^{-1} \sqrt E^{-1}`, output
   :math:`\dot\psi` (4.7-4.9);
3. four dimensions: :math:`x = (\sigma, H^{-1} \dot\sigma)`, output :math:`\psi` (4.10-4.11);
4. response to held torques: :math:`\dot\sigma(t) = e^{-Ht} \dot\sigma_0 + a(t) u`,
   :math:`\sigma(t) = \sigma_0 + a(t) \dot\sigma_0 + b(t) u`,
   :math:`a = (1 - e^{-ht})/h, b = (t - a)/h` (4.26-4.30).

Viscous friction only. Misprints: the output of (4.9) is the motor rate, not the angle; the signs of
the second and fourth blocks of (4.18) are +; the exponents in (4.19) are -3/2: YH has the
entries :math:`\pm (2\pi/p_c) g_i e_i^{-3/2}`, the printed -2/3 is dimensionally wrong too.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .c_drive import (
    CDriveParameters,
    damping_matrix,
    inertia_matrix,
    inverse_jacobian,
    jacobian,
)

Matrix = NDArray[np.float64]


class StateSpace(NamedTuple):
    """x' = A x + B u, y = C x."""

    A: Matrix
    B: Matrix
    C: Matrix


class CollarModes(NamedTuple):
    """Inertia and friction of the two decoupled directions, (translation, rotation)."""

    inertia: Matrix  # e (2,), eigenvalues of M [kg m^2]
    damping: Matrix  # g (2,), eigenvalues of D [N m s/rad]

    @property
    def rate(self) -> Matrix:
        """Decay rates h = g / e (2,) [1/s] of eq. (4.5)."""
        return self.damping / self.inertia


def collar_modes(parameters: CDriveParameters) -> CollarModes:
    """Diagonals of E and G of eq. (4.3b), by the similarity with J."""
    J, J_inverse = jacobian(parameters.lead), inverse_jacobian(parameters.lead)
    return CollarModes(
        np.diag(J @ inertia_matrix(parameters) @ J_inverse),
        np.diag(J @ damping_matrix(parameters) @ J_inverse),
    )


def to_sigma(parameters: CDriveParameters) -> Matrix:
    """Matrix sqrt(E) J [m kg^(1/2) m/rad]: sigma from the motor angles (4.20b)."""
    return np.diag(np.sqrt(collar_modes(parameters).inertia)) @ jacobian(parameters.lead)


def to_input(parameters: CDriveParameters) -> Matrix:
    """Matrix sqrt(E)^-1 J: u from the motor torques (4.4)."""
    return np.diag(1.0 / np.sqrt(collar_modes(parameters).inertia)) @ jacobian(parameters.lead)


def output_matrix(parameters: CDriveParameters) -> Matrix:
    """Y = J^-1 sqrt(E)^-1 of eq. (4.11): motor angles from sigma."""
    inertia = collar_modes(parameters).inertia
    return inverse_jacobian(parameters.lead) @ np.diag(1.0 / np.sqrt(inertia))


def two_dimensional(parameters: CDriveParameters) -> StateSpace:
    """Eq. (4.9): state x = sigma', input u, output the motor rates [rad/s]."""
    H = np.diag(collar_modes(parameters).rate)
    return StateSpace(-H, np.eye(2), output_matrix(parameters))


def four_dimensional(parameters: CDriveParameters) -> StateSpace:
    """Eq. (4.11): state x = (sigma, H^-1 sigma'), input u, output the motor angles [rad].

    Raises ValueError if a direction of the collar has no viscous friction: H must be invertible.
    """
    h = collar_modes(parameters).rate
    if not np.all(h > 0.0):
        raise ValueError(
            f"H has the diagonal {h.tolist()}; expected viscous friction in both directions, "
            "or H^-1 of eq. (4.10) does not exist"
        )
    zero, H = np.zeros((2, 2)), np.diag(h)
    return StateSpace(
        np.block([[zero, H], [zero, -H]]),
        np.vstack([zero, np.diag(1.0 / h)]),
        np.hstack([output_matrix(parameters), zero]),
    )


def controllability_matrix(system: StateSpace) -> Matrix:
    """Gamma = [B, AB, ..., A^(n-1) B], (n, n m), of eqs. (4.12) and (4.15)."""
    blocks = [system.B]
    for _ in range(system.A.shape[0] - 1):
        blocks.append(system.A @ blocks[-1])
    return np.hstack(blocks)


def observability_matrix(system: StateSpace) -> Matrix:
    """Omega = [C; CA; ...; C A^(n-1)], (n p, n), of eqs. (4.13) and (4.18)."""
    blocks = [system.C]
    for _ in range(system.A.shape[0] - 1):
        blocks.append(blocks[-1] @ system.A)
    return np.vstack(blocks)


def is_controllable(system: StateSpace) -> bool:
    """True if the controllability matrix, its rows scaled to unit length, has full rank."""
    return _full_rank(controllability_matrix(system))


def is_observable(system: StateSpace) -> bool:
    """True if the observability matrix, its columns scaled to unit length, has full rank."""
    return _full_rank(observability_matrix(system).T)


def held_torque_response(
    parameters: CDriveParameters,
    angle: ArrayLike,
    rate: ArrayLike,
    torque: ArrayLike,
    t: ArrayLike,
) -> tuple[Matrix, Matrix]:
    """Motor angles and rates (..., 2) at times ``t`` (...) [s] under constant torques (2,) [N m].

    Starts from ``angle`` [rad] and ``rate`` [rad/s], (2,). Eqs. (4.26-4.30) with the integral z2
    in closed form; directions without friction take the limit h -> 0.
    """
    h = collar_modes(parameters).rate
    time = np.asarray(t, dtype=float)[..., None]
    with np.errstate(divide="ignore", invalid="ignore"):
        a = np.where(h > 0.0, -np.expm1(-h * time) / h, time)
        b = np.where(h > 0.0, (time - a) / h, 0.5 * time**2)
    S, Y = to_sigma(parameters), output_matrix(parameters)
    sigma, x = S @ np.asarray(angle, dtype=float), S @ np.asarray(rate, dtype=float)
    u = to_input(parameters) @ np.asarray(torque, dtype=float)
    return (sigma + a * x + b * u) @ Y.T, (np.exp(-h * time) * x + a * u) @ Y.T


def _full_rank(matrix: Matrix) -> bool:
    length = np.linalg.norm(matrix, axis=1, keepdims=True)
    if not np.all(length > 0.0):
        return False
    return bool(np.linalg.matrix_rank(matrix / length) == matrix.shape[0])
