r"""2PRU-1PRS multi-axial simulation table, sliders vertical (Roldan, section 4.2 and appendix B.2).

Legs 1 and 3 lie in the plane xz at x = H and -H, leg 2 in the plane yz at y = H. The platform moves in z, psi and
theta, with the parasitic :math:`x = -r \sin\psi \sin\theta`; y and phi stay zero. The universal joints of legs 1 and
3 repeat two constraints (7 independent of 9).

Corrected here: (B.34) is :math:`-L r \sin\theta \sin\psi \sin\gamma_2`, printed with + and gamma_1. (B.42) the last rate
is that of psi. (B.56) first row, third entry is :math:`+\frac12 (r \sin\theta - r \cos\theta \sin\psi)` and third row,
third entry :math:`-(r \sin\theta - r \cos\theta \sin\psi) / (L \sin\gamma_3)`, as (A.28) of the article has it.

Printed: H, r, L, masses of a bar and of the platform. Assumed: a slender bar, the platform as a thin disc of radius r
(:math:`m r^2/4, m r^2/2`), centre of mass at P. The carriages belong to the actuators, which carry their mass.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import prs

Floats = NDArray[np.float64]

SPAN, JOINTS, BAR = 0.4, 0.35, 0.26  # H, r, L [m]
BAR_MASS, PLATFORM_MASS = 0.07, 2.06  # [kg]
DISC = PLATFORM_MASS * JOINTS**2 / 4.0  # assumed [kg m^2]
LIMIT = np.deg2rad(20.0)  # largest rotation of the platform in use [rad]
STROKE = 0.3  # of a linear guide [m]

MAST = prs.Table(
    azimuths=(0.0, 0.5 * np.pi, np.pi),
    start=SPAN,
    slide=(0.0, 1.0),
    bar=BAR,
    radius=JOINTS,
    home=float(np.sqrt(BAR**2 - (SPAN - JOINTS) ** 2)),  # sliders at zero, level
    bar_mass=BAR_MASS,
    bar_inertia=BAR_MASS * BAR**2 / 12.0,
    platform_mass=PLATFORM_MASS,
    platform_inertia=(DISC, DISC, 2.0 * DISC, 0.0, 0.0, 0.0),
)


def printed_jacobians(task: ArrayLike, table: prs.Table = MAST) -> tuple[Floats, Floats]:
    """J_x and J_q (..., 3, 3) of :math:`J_x (z', psi', theta') = J_q rho'` (B.28)-(B.38), corrected."""
    x = np.asarray(task, dtype=float)
    psi, theta = x[..., 1], x[..., 2]
    g1, g2, g3 = np.moveaxis(prs.slopes(prs.pose(x, table), prs.inverse(x, table), table), -1, 0)
    s, c, r = np.sin, np.cos, table.radius
    rows = [
        (s(g1), r * s(theta) * c(psi) * c(g1), r * (c(theta) * s(psi) * c(g1) + s(theta - g1))),
        (
            s(g2),
            r * (s(psi) * c(g2) + c(theta) * c(psi) * s(g2)),
            -r * s(theta) * s(psi) * s(g2),
        ),
        (
            s(g3),
            -r * s(theta) * c(psi) * c(g3),
            r * (s(theta + g3) - c(theta) * s(psi) * c(g3)),
        ),
    ]
    by_task = table.bar * np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    by_slider = table.bar * np.stack([s(g1), s(g2), s(g3)], axis=-1)[..., None] * np.eye(3)
    return by_task, by_slider
