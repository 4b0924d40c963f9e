r"""Hysteresis of a piezo stack, as a voltage that is lost between terminals and ceramic.

1. Bouc-Wen      :math:`\dot v = \alpha\dot V - \beta|\dot V|v - \gamma\dot V|v|`
2. Maxwell slip  :math:`v = \sum_i v_i`, :math:`\dot v_i = \kappa_i\dot q` while :math:`|v_i| < \bar v_i` or the
   charge returns, else 0; :math:`q = T x + C(V - v)`

(2) is the Maxwell resistive capacitor of Goldfarb and Celanovic 1997 (reference 43 of Damani 2013):
it acts between charge and voltage, so that the length x of a stack that is held reacts on it. Solved for
the charge, :math:`\dot q = (\dot V + T\dot x/C) / (1/C + \sum_{sticking}\kappa_i)`. Both are
rate-independent: creep is not modelled.

3. stop          :math:`v = \sum_i a_i s_i`, :math:`\dot s_i = \dot V` while :math:`|s_i| < r_i`

(3) is (2) of a stack that carries no load, driven by its voltage: :math:`V - s_i` is the play operator of
limit r_i, so that the length is that of the Prandtl-Ishlinskii model (Kuhnen 2003).
"""

from typing import Any

import numpy as np


def bouc_wen_rate(lost: Any, drive_rate: Any, alpha: Any, beta: Any, gamma: Any) -> Any:
    """Rate of the lost voltage (1) [V/s] at ``drive_rate`` [V/s]; beta and gamma in 1/V."""
    return alpha * drive_rate - beta * np.abs(drive_rate) * lost - gamma * drive_rate * np.abs(lost)


def bouc_wen_step(lost: Any, change: Any, alpha: Any, beta: Any, gamma: Any) -> Any:
    """Lost voltage (1) after the drive has changed by ``change`` [V]; classical Runge-Kutta."""
    k1 = bouc_wen_rate(lost, change, alpha, beta, gamma)
    k2 = bouc_wen_rate(lost + 0.5 * k1, change, alpha, beta, gamma)
    k3 = bouc_wen_rate(lost + 0.5 * k2, change, alpha, beta, gamma)
    k4 = bouc_wen_rate(lost + k3, change, alpha, beta, gamma)
    return lost + (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0


def stop(element: Any, change: Any, limit: Any) -> Any:
    """Voltage s_i (3) of an element after the drive has changed by ``change`` [V]; exact."""
    return min(max(element + change, -limit), limit)


def element_sticks(voltage: Any, limit: Any, charge_direction: Any) -> bool:
    """Whether a Maxwell element follows the charge: below its limit, or when the charge returns."""
    return bool(np.abs(voltage) < limit or voltage * charge_direction < 0.0)


def charge_rate(
    drive_rate: Any, length_rate: Any, transduction: Any, capacitance: Any, slope: Any
) -> Any:
    """Charge rate [C/s] when the sticking elements together have ``slope`` [V/C] (2)."""
    return (drive_rate + transduction * length_rate / capacitance) / (1.0 / capacitance + slope)
