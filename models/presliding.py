r"""Elastoplastic presliding: the LuGre contact that does not creep below its elastic limit.

1. :math:`\dot z = v - \alpha(v, z)\,\sigma_0 |v| z / g(v)`, ``friction.bristle_rate`` with :math:`\alpha\sigma_0`
2. :math:`\alpha = 0` for :math:`|z| \le \beta z_s` or a bristle that is being unloaded (:math:`vz < 0`), 1 for
   :math:`|z| \ge z_s`, a half sine wave between; :math:`z_s = g/\sigma_0`

The contact *sticks* while :math:`\alpha = 0`, where its motion is purely elastic, and *slips* otherwise.
3. generalised Maxwell slip: elements in parallel, each a spring that sticks, :math:`\dot F_i = k_i v`, until
   :math:`|F_i| = \alpha_i g(v)`, then slips, :math:`\dot F_i = C (\alpha_i \mathrm{sgn}\,v - F_i / g(v))`, until
   the speed changes sign; :math:`f = \sum F_i + \sigma_i \dot z_i + b v` with :math:`F_i = k_i z_i`

With :math:`\beta = 0`, :math:`\alpha = 1` always: the LuGre model, whose every motion under load creeps. Source:
Dupont, Hayward, Armstrong 2002 (reference 41 of Damani 2013), used for stick-slip drives by Peng and Chen
2011 (reference 18). (3): Roldan, eq. (2.28); the element's law by Al-Bender, Lampaert, Swevers 2005 (his
reference 76), which Roldan does not print.
"""

from typing import Any

import numpy as np


def plastic_share(v: Any, deflection: Any, elastic: Any, steady: Any) -> Any:
    """Share alpha (2) of the sliding term, for elastic limit and steady deflection [m]."""
    if elastic <= 0.0:
        return 1.0
    if v * deflection < 0.0:
        return 0.0
    size = np.abs(deflection)
    if size <= elastic:
        return 0.0
    if size >= steady:
        return 1.0
    return 0.5 + 0.5 * np.sin(np.pi * ((size - elastic) / (steady - elastic) - 0.5))


def maxwell_step(
    v: float,
    force: float,
    slipping: bool,
    stiffness: float,
    share: float,
    level: float,
    attraction: float,
    dt: float,
) -> tuple[float, bool]:
    """Force of one element of (3) and whether it slips, after ``dt`` at constant speed (floats).

    ``share`` is alpha, the part of ``level`` g(v) that this element carries; all shares add up to 1.
    ``attraction`` is C, how fast a slipping element approaches its level [N/s]; slip is solved exactly.
    """
    limit = share * level
    if slipping and v * force < 0.0:
        slipping = False
    if not slipping:
        force += stiffness * v * dt
        if np.abs(force) < limit:
            return force, False
        return np.sign(force) * limit, True
    if v == 0.0:
        return force, True
    steady = np.sign(v) * limit
    return steady + (force - steady) * np.exp(-attraction * dt / level), True
