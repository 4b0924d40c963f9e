r"""Extreme heights of the PepperMill-Carrier by constrained optimisation (Friedlaender 2015, 2.5.3).

1. maximise or minimise :math:`z(\theta_1, \theta_2)` at fixed :math:`d_1, d_2` (2.27)
2. subject to the safe drive angles (2.28a) and :math:`\phi_{min} \le \phi \le \phi_{max}` (2.28b)

Solved as in the thesis by sequential quadratic programming with exact gradients, in scaled variables:
:math:`z/r` and :math:`(\phi - \phi_c)/(\pi n)`. Each optimum carries two certificates: the residual of the
Karush-Kuhn-Tucker conditions, and its distance from the best point of a dense grid. (2.28a) prints
:math:`\theta_1` in the bounds of :math:`\theta_2`.
"""

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import Bounds, NonlinearConstraint, minimize, nnls

from ...models.pmc import kinematics, limits
from ...models.pmc.geometry import Geometry

Floats = NDArray[np.float64]
Extreme = Literal["low", "high"]

# A constraint within this scaled distance of its bound counts as active [-].
ACTIVE = 1e-6


@dataclass(frozen=True, kw_only=True)
class Optimum:
    """One extreme height and how well it is established."""

    z: float  # [m]
    joints: Floats  # (4,) d1, d2 [m], theta1, theta2 [rad]
    phi: float  # [rad]
    kkt_residual: float  # norm of the unbalanced gradient of z/r [-]
    violation: float  # largest scaled violation of a constraint [-]
    grid_z: float  # best feasible point of the dense grid [m]
    grid_bound: float  # how far the grid may fall short for its spacing [m]


def extreme_height(
    d1: float, d2: float, extreme: Extreme, geometry: Geometry, *, grid: int = 201
) -> Optimum | None:
    """Lowest or highest z over the carriage positions ``d1``, ``d2`` [m]; None if nothing is feasible.

    ``grid`` points a side make the check. Raises ValueError outside the stroke.
    """
    for name, d in (("d1", d1), ("d2", d2)):
        if not geometry.carriage_min <= d <= geometry.carriage_max:
            raise ValueError(
                f"{name} is {d} m; expected it in the stroke "
                f"[{geometry.carriage_min}, {geometry.carriage_max}] m"
            )
    problem = _Problem(d1, d2, 1.0 if extreme == "low" else -1.0, geometry)
    best = _dense_grid(problem, grid)
    if best is None:
        return None
    grid_z, grid_bound = best
    result = minimize(
        problem.objective,
        np.mean(problem.bounds, axis=1),
        jac=problem.objective_gradient,
        bounds=Bounds(*np.transpose(problem.bounds)),
        constraints=NonlinearConstraint(problem.slack, 0.0, np.inf, jac=problem.slack_gradient),
        method="SLSQP",
        options={"ftol": 1e-14, "maxiter": 200},
    )
    pose = problem.pose(result.x)
    return Optimum(
        z=float(pose[2]),
        joints=problem.joints(result.x),
        phi=float(pose[3]),
        kkt_residual=_kkt_residual(problem, result.x),
        violation=float(max(0.0, -problem.slack(result.x).min())),
        grid_z=grid_z,
        grid_bound=grid_bound,
    )


class _Problem:
    """The scaled problem in the two drive angles; ``sign`` is -1 to maximise."""

    def __init__(self, d1: float, d2: float, sign: float, geometry: Geometry) -> None:
        self.d = (d1, d2)
        self.sign = sign
        self.geometry = geometry
        self.bounds = limits.theta_bounds(geometry)
        self.half_range = np.pi * geometry.turns

    def joints(self, theta: Floats) -> Floats:
        theta = np.asarray(theta, dtype=float)
        d = np.broadcast_to(self.d, theta.shape)
        return np.concatenate([d, theta], axis=-1)

    def pose(self, theta: Floats) -> Floats:
        return kinematics.forward(self.joints(theta), self.geometry)

    def _angle_jacobian(self, theta: Floats) -> Floats:
        """(2, 2): rows z and phi, columns theta1 and theta2."""
        joints = self.joints(theta)
        pose = kinematics.forward(joints, self.geometry)
        return kinematics.jacobian(pose, joints, self.geometry)[2:, 2:]

    def objective(self, theta: Floats) -> float:
        return float(self.sign * self.pose(theta)[2] / self.geometry.proximal)

    def objective_gradient(self, theta: Floats) -> Floats:
        return self.sign * self._angle_jacobian(theta)[0] / self.geometry.proximal

    def turn(self, phi: Any) -> Any:
        return (phi - self.geometry.centre_angle) / self.half_range

    def slack(self, theta: Floats) -> Floats:
        """Screw constraints (2.28b), not negative where met."""
        turn = self.turn(self.pose(theta)[3])
        return np.array([1.0 - turn, 1.0 + turn])

    def slack_gradient(self, theta: Floats) -> Floats:
        gradient = self._angle_jacobian(theta)[1] / self.half_range
        return np.array([-gradient, gradient])


def _dense_grid(problem: _Problem, n: int) -> tuple[float, float] | None:
    """Best z of the feasible grid points, and the most that the spacing can hide.

    A cell that holds the optimum moves each wrist by at most g times the spacing; leaving it for a feasible
    grid point moves the other wrist as much again.
    """
    axes = [np.linspace(low, high, n) for low, high in problem.bounds]
    theta = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
    joints = problem.joints(theta)
    pose = kinematics.forward(joints, problem.geometry)
    feasible = np.abs(problem.turn(pose[:, 3])) <= 1.0
    if not feasible.any():
        return None
    cost = np.where(feasible, problem.sign * pose[:, 2], np.inf)
    best = int(np.argmin(cost))
    links = kinematics.link_elevations(pose, joints, problem.geometry)
    gain = np.sin(links[:, 1::2] - links[:, 0::2]) / np.sin(links[:, 1::2])
    steepest = problem.geometry.proximal * float(np.abs(gain).max())
    spacing = max(axis[1] - axis[0] for axis in axes)
    return float(pose[best, 2]), 2.0 * steepest * float(spacing)


def _kkt_residual(problem: _Problem, theta: Floats) -> float:
    """Norm of what is left of the gradient after the best non-negative multipliers of active constraints."""
    gradients = []
    for i, (low, high) in enumerate(problem.bounds):
        unit = np.eye(2)[i]
        if theta[i] - low < ACTIVE:
            gradients.append(unit)
        if high - theta[i] < ACTIVE:
            gradients.append(-unit)
    slack, slopes = problem.slack(theta), problem.slack_gradient(theta)
    gradients += [slope for value, slope in zip(slack, slopes) if value < ACTIVE]
    gradient = problem.objective_gradient(theta)
    if not gradients:
        return float(np.linalg.norm(gradient))
    columns = np.array(gradients).T
    multipliers, _ = nnls(columns, gradient)
    return float(np.linalg.norm(columns @ multipliers - gradient))
