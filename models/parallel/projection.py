r"""The sum over bodies of energy equivalence (Roldan, eq. 3.37), for compiled loops and batches alike.

.. math:: I = \sum_b J_b^T M_b J_b,\quad C = \sum_b J_b^T M_b \dot J_b \dot q,\quad G = \sum_b J_b^T g_b

with diagonal :math:`M_b`: rows of coordinates, each with its own mass or moment of inertia.
"""

from typing import Any


def project(
    jacobian: Any, drift: Any, mass: Any, pull: Any, inertia: Any, velocity: Any, gravity: Any
) -> None:
    """Write I (n, n), C (n,) and G (n,) of bodies with Jacobians (b, rows, n), drifts and loads (b, rows).

    ``drift`` is Jdot times the rates, ``mass`` the diagonals of M and ``pull`` the weights g.
    """
    bodies, rows, n = jacobian.shape
    inertia[:, :] = 0.0
    velocity[:] = 0.0
    gravity[:] = 0.0
    for b in range(bodies):
        for k in range(rows):
            for i in range(n):
                by = jacobian[b, k, i]
                velocity[i] += by * mass[b, k] * drift[b, k]
                gravity[i] += by * pull[b, k]
                for j in range(n):
                    inertia[i, j] += by * mass[b, k] * jacobian[b, k, j]
