r"""Drive trains of one, two or N inertias, as state space and as transfer functions (Roldan, section 3.2.2).

.. math:: J \ddot\theta + C \dot\theta + K \theta = (\tau_m, 0, .., 0, -\tau_d)

1. one inertia (3.4-3.6): :math:`\theta/\tau = 1/(J s^2 + c s)`
2. two inertias (3.9-3.12): ``two_inertia_transfer``
3. N inertias (3.13-3.23): :math:`M(s)\theta = F`, and by elimination from the load's end
   :math:`TF_i = \theta_i/\theta_{i-1}`, :math:`TF_1 = \theta_1/\tau`; ``modal_response`` sums modes (3.24, 3.25)

All inertias, stiffnesses and dampings are seen from the motor's shaft, angles in rad, torques in N m. Corrected
here: the disturbance opposes the motor, so (3.11) enters (3.7) with a minus sign; (3.22) repeats (3.21) and
should be :math:`\theta_2/\theta_1`; (3.16) prints :math:`k_3` in the last column. The modal sums hold for damping
in proportion to the stiffness or the inertia only.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import eigh

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]


class Transfer(NamedTuple):
    """A rational transfer function: coefficients of numerator and denominator, highest power first."""

    numerator: tuple[float, ...]
    denominator: tuple[float, ...]

    def __call__(self, s: ArrayLike) -> Complexes:
        """Value at complex frequencies ``s`` [rad/s]."""
        s = np.asarray(s)
        return np.asarray(np.polyval(self.numerator, s) / np.polyval(self.denominator, s))


@dataclass(frozen=True, kw_only=True)
class DriveTrain:
    """A chain of inertias from the motor to the load, on the motor's shaft.

    Raises ValueError for an inertia or stiffness that is not positive, a negative damping, or counts that do
    not fit together.
    """

    inertias: tuple[float, ...]  # J_1 .. J_N [kg m^2]
    stiffnesses: tuple[float, ...] = ()  # k_1 .. k_(N-1), between neighbours [N m/rad]
    dampings: tuple[float, ...] = ()  # c_1 .. c_(N-1) [N m s/rad]
    bearings: tuple[float, ...] = ()  # viscous, of each inertia against the ground [N m s/rad]

    def __post_init__(self) -> None:
        n = len(self.inertias)
        if n < 1 or len(self.stiffnesses) != n - 1 or len(self.dampings) != n - 1:
            raise ValueError(
                f"{n} inertias, {len(self.stiffnesses)} stiffnesses, {len(self.dampings)} dampings; "
                "expected at least one inertia, and one of each less than inertias of the others"
            )
        if len(self.bearings) not in (0, n):
            raise ValueError(f"{len(self.bearings)} bearings; expected none or {n}")
        if not min(*self.inertias, *self.stiffnesses, np.inf) > 0.0:
            raise ValueError("an inertia or stiffness is not positive; expected values above 0")
        if min(*self.dampings, *self.bearings, 0.0, 0.0) < 0.0:
            raise ValueError("a damping is negative; expected values of at least 0")

    @property
    def inertia(self) -> Floats:
        """J (N, N) of (3.14) [kg m^2]."""
        return np.diag(np.array(self.inertias))

    @property
    def damping(self) -> Floats:
        """Damping c (N, N) of (3.15) with the bearings on its diagonal [N m s/rad]."""
        bearings = np.array(self.bearings or [0.0] * len(self.inertias))
        return _chain(self.dampings) + np.diag(bearings)

    @property
    def stiffness(self) -> Floats:
        """Stiffness k (N, N) of (3.16) [N m/rad]."""
        return _chain(self.stiffnesses)

    def state_space(self) -> tuple[Floats, Floats, Floats]:
        """A (2N, 2N), B (2N, 2), C (N, 2N): states angles and rates; inputs tau_m and tau_d; outputs angles."""
        n = len(self.inertias)
        inverse = np.diag(1.0 / np.array(self.inertias))
        a = np.block(
            [[np.zeros((n, n)), np.eye(n)], [-inverse @ self.stiffness, -inverse @ self.damping]]
        )
        b = np.zeros((2 * n, 2))
        b[n, 0], b[-1, 1] = inverse[0, 0], -inverse[-1, -1]
        return a, b, np.eye(n, 2 * n)

    def response(self, s: ArrayLike) -> Complexes:
        """Angles (..., N, 2) per tau_m and tau_d at complex frequencies ``s`` (...) [rad/s], by (3.19, 3.20)."""
        z = np.asarray(s, dtype=complex)[..., None, None]
        forces = np.zeros((len(self.inertias), 2))
        forces[0, 0], forces[-1, 1] = 1.0, -1.0
        matrix = self.inertia * z**2 + self.damping * z + self.stiffness
        return np.asarray(
            np.linalg.solve(matrix, np.broadcast_to(forces, (*z.shape[:-2], *forces.shape)))
        )

    def transfers(self, s: ArrayLike) -> list[Complexes]:
        """TF_1 = theta_1/tau_m, then TF_i = theta_i/theta_(i-1), by elimination (3.21-3.23)."""
        z = np.asarray(s, dtype=complex)
        ground = self.bearings or (0.0,) * len(self.inertias)
        links = [c * z + k for c, k in zip(self.dampings, self.stiffnesses)]
        chain: list[Complexes] = []
        beyond: Complexes = np.zeros_like(z)  # what the inertias beyond hang on this one
        for i in range(len(self.inertias) - 1, -1, -1):
            own = self.inertias[i] * z**2 + ground[i] * z + beyond
            if i == 0:
                chain.append(1.0 / own)
                break
            chain.append(links[i - 1] / (own + links[i - 1]))
            beyond = links[i - 1] * (1.0 - chain[-1])
        return chain[::-1]

    def modes(self) -> tuple[Floats, Floats, Floats]:
        """Natural frequencies (N,) [rad/s], shapes (N, N) in columns with unit modal mass, 2 xi omega (N,)."""
        squares, shapes = eigh(self.stiffness, self.inertia)
        damping = np.einsum("im,ij,jm->m", shapes, self.damping, shapes)
        return np.sqrt(np.maximum(squares, 0.0)), shapes, damping


def modal_response(train: DriveTrain, s: ArrayLike) -> tuple[Complexes, Complexes]:
    """TF_1 = theta_1/tau_m and theta_N/theta_1 by the sums over modes (3.24, 3.25)."""
    frequencies, shapes, damping = train.modes()
    z = np.asarray(s, dtype=complex)[..., None]
    single = 1.0 / (z**2 + damping * z + frequencies**2)
    first = np.sum(shapes[0] ** 2 * single, axis=-1)
    return first, np.sum(shapes[-1] * shapes[0] * single, axis=-1) / first


def one_inertia_transfer(inertia: float, viscous: float) -> Transfer:
    """Angle per torque (3.5), rad/(N m)."""
    return Transfer((1.0,), (inertia, viscous, 0.0))


def two_inertia_transfer(j1: float, j2: float, c: float, k: float) -> dict[str, Transfer]:
    """(3.9)-(3.12): ``motor`` = TF_1, ``load`` = TF_2, ``load_by_disturbance`` = TF_1d, ``motor_by_load`` = TF_2d.

    TF_1d is per torque *on* the load; the disturbance of (3.4) opposes it.
    """
    common = (j1 * j2, (j1 + j2) * c, (j1 + j2) * k, 0.0, 0.0)
    return {
        "motor": Transfer((j2, c, k), common),
        "load": Transfer((c, k), (j2, c, k)),
        "load_by_disturbance": Transfer((j1, c, k), common),
        "motor_by_load": Transfer((c, k), (j1, c, k)),
    }


def _chain(values: tuple[float, ...]) -> Floats:
    """Matrix of springs between neighbours (3.15, 3.16)."""
    n = len(values) + 1
    matrix = np.zeros((n, n))
    for i, value in enumerate(values):
        matrix[i : i + 2, i : i + 2] += value * np.array([[1.0, -1.0], [-1.0, 1.0]])
    return matrix
