"""Compiled loops of energy equivalence: batches of postures, and one five-bar at a time."""

from typing import Any

import numpy as np

from .. import compilation
from . import linkage, projection

compilation.register_laws(linkage, projection)


@compilation.kernel
def project_all(
    jacobian: Any, drift: Any, mass: Any, pull: Any, inertia: Any, velocity: Any, gravity: Any
) -> None:
    """``projection.project`` of a batch: Jacobians (batch, b, rows, n), results (batch, ...)."""
    for s in range(jacobian.shape[0]):
        projection.project(jacobian[s], drift[s], mass, pull, inertia[s], velocity[s], gravity[s])


@compilation.kernel
def five_bar_motion(q: Any, v: Any, lengths: Any, bodies: Any) -> Any:
    """Jacobian (b, 3, 2) and drift (b, 3) of the bodies of ``five_bar_equations``."""
    base, l1, l2, l3, l4, mode = lengths
    at = linkage.rods(q[0], q[1], v[0], v[1], base, l1, l2, l3, l4, mode)
    two, three, by21, by24, by31, by34, drift2, drift3 = at
    angle = (q[0], two, three, q[1])
    by1, by4 = (1.0, by21, by31, 0.0), (0.0, by24, by34, 1.0)
    drifts = (0.0, drift2, drift3, 0.0)
    count = bodies.shape[0]
    jacobian, drift = np.zeros((count, 3, 2)), np.zeros((count, 3))
    for b in range(count):
        for arm in range(2):
            link, length = int(bodies[b, 2 * arm]), bodies[b, 2 * arm + 1]
            rate = by1[link] * v[0] + by4[link] * v[1]
            x1, x4, y1, y4, dx, dy = linkage.arm(
                length, angle[link], rate, by1[link], by4[link], drifts[link]
            )
            jacobian[b, 0, 0] += x1
            jacobian[b, 0, 1] += x4
            jacobian[b, 1, 0] += y1
            jacobian[b, 1, 1] += y4
            drift[b, 0] += dx
            drift[b, 1] += dy
        turning = int(bodies[b, 2])
        jacobian[b, 2, 0], jacobian[b, 2, 1] = by1[turning], by4[turning]
        drift[b, 2] = drifts[turning]
    return jacobian, drift


@compilation.kernel
def five_bar_equations(q: Any, v: Any, lengths: Any, bodies: Any, weight: float) -> Any:
    """I (2, 2), C (2,) and G (2,) of a five-bar at crank angles and rates (2,).

    ``lengths`` are base, l1 .. l4 and the mode; a row of ``bodies`` is first link, arm along it, second
    link, arm along it, mass and inertia; the body turns with its second link. Links count 0 .. 3 from
    crank 1 to crank 4.
    """
    count = bodies.shape[0]
    mass, pull = np.empty((count, 3)), np.zeros((count, 3))
    jacobian, drift = five_bar_motion(q, v, lengths, bodies)
    for b in range(count):
        mass[b, 0] = mass[b, 1] = bodies[b, 4]
        mass[b, 2] = bodies[b, 5]
        pull[b, 1] = weight * bodies[b, 4]
    inertia, velocity, gravity = np.empty((2, 2)), np.empty(2), np.empty(2)
    projection.project(jacobian, drift, mass, pull, inertia, velocity, gravity)
    return inertia, velocity, gravity
