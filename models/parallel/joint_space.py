r"""Which crank angles of a five-bar are safe: margins of assembly, singularity and crossing cranks.

The rods meet at angle :math:`\mu` with :math:`|AB|^2 = l_2^2 + l_3^2 - 2 l_2 l_3 \cos\mu`; the tool has no velocity
along one direction at mu = 0 and pi (parallel singularities). Cranks that pass each other change the assembly.
The source draws its joint spaces (Figs. 6.4, 6.14) without their rule: this one is ours.
"""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .five_bar import FiveBar

Floats = NDArray[np.float64]


def margin(
    cranks: ArrayLike,
    machine: FiveBar,
    least: float = np.deg2rad(20.0),
    clearance: float = 0.02,
) -> Floats:
    """Smallest margin (...) of crank angles (..., 2), in lengths of the machine [m]; positive is safe.

    ``least`` is how far mu keeps from 0 and pi [rad], ``clearance`` how far A stays left of B [m].
    """
    q = np.asarray(cranks, dtype=float)
    tips = [
        length * np.stack([np.cos(angle), np.sin(angle)], axis=-1) + np.array([shift, 0.0])
        for length, angle, shift in (
            (machine.crank1, q[..., 0], -0.5 * machine.base),
            (machine.crank4, q[..., 1], 0.5 * machine.base),
        )
    ]
    across = tips[1] - tips[0]
    apart = np.hypot(across[..., 0], across[..., 1])
    near, far = (_distance(machine, mu) for mu in (least, np.pi - least))
    return np.min([far - apart, apart - near, across[..., 0] - clearance], axis=0)


def _distance(machine: FiveBar, mu: float) -> float:
    squares = machine.rod2**2 + machine.rod3**2
    return float(np.sqrt(squares - 2.0 * machine.rod2 * machine.rod3 * np.cos(mu)))
