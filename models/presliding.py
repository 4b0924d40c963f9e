r"""Elastoplastic presliding: the LuGre contact that does not creep below its elastic limit.

1. :math:`\dot z = v - \alpha(v, z)\,\sigma_0 |v| z / g(v)`, ``friction.bristle_rate`` with :math:`\alpha\sigma_0`
2. :math:`\alpha = 0` for :math:`|z| \le \beta z_s` or a bristle that is being unloaded (:math:`vz < 0`), 1 for
   :math:`|z| \ge z_s`, a half sine wave between; :math:`z_s = g/\sigma_0`

The contact *sticks* while :math:`\alpha = 0`, where its motion is purely elastic, and *slips* otherwise.
With :math:`\beta = 0`, :math:`\alpha = 1` always: the LuGre model, whose every motion under load creeps. Source:
Dupont, Hayward, Armstrong 2002 (reference 41 of Damani 2013), used for stick-slip drives by Peng and Chen
2011 (reference 18).
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
