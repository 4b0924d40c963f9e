r"""A joint on a position servo, from its reference to its measured angle, in units of the servo's stiffness.

A geared servo with proportional and derivative action turns a position error into torque,
:math:`\tau = K(r - q) - D\dot q`. All torques are divided by K, so that they are errors in rad that hold
the servo against them:

1. motion: :math:`a\ddot q = \mathrm{sat}(r - q) + g - T\dot q - f\,\mathrm{sgn}\,\dot q`, with the inertia
   over stiffness a, the damping over stiffness T (a time constant), the load g and the dry friction
   f = level + share \|g\|;
2. a step of h seconds, implicit in speed, damping, stiffness and friction:
   :math:`\dot q^+ = S(a\dot q + h(r - q + g),\ hf) / (a + hT + h^2)`, S the soft threshold of (3);
3. :math:`S(x, w) = \mathrm{sgn}(x)\max(|x| - w, 0)`: sticking is exact, and a = T = 0 is a play operator;
4. clearance between servo and measured angle: a play of half its gap, :math:`|q - y| \le w / 2`.

The speed is limited, and so is the error that still adds torque. The reference is delayed, then lagged.
Signs: a positive load turns towards larger angles. Not modelled: sampling of the servo's own loop,
elasticity, inertia of the other joints' motion.

Source of (2): the implicit Euler step for dry friction as a set-valued law (Acary and Brogliato 2008,
ch. 1.4), of first order in h.
"""

from typing import Any, NamedTuple

import numpy as np


class PositionServo(NamedTuple):
    """Constants of one joint, torques over stiffness."""

    damping: float  # T [s]
    inertia: float  # a [s^2]
    level: float  # dry friction [rad]
    share: float  # of the load that is friction [-]
    speed_limit: float  # [rad/s]
    error_limit: float  # largest error that adds torque [rad]
    delay: float  # of the reference [s]
    lag: float  # time constant behind the delay [s]
    gap: float  # clearance between servo and measured angle [rad]
    scale_error: float  # of the measured angle [-]
    zero: float  # of the measured angle [rad]


def ideal_servo(damping: float, inertia: float, delay: float) -> PositionServo:
    """A servo without friction, limits, clearance or sensor errors."""
    return PositionServo(
        damping=damping, inertia=inertia, level=0.0, share=0.0,
        speed_limit=np.inf, error_limit=np.inf, delay=delay, lag=0.0, gap=0.0, scale_error=0.0,
        zero=0.0,
    )  # fmt: skip


def soft_threshold(x: Any, width: Any) -> Any:
    """(3): ``x`` less ``width`` towards zero."""
    if x > width:
        return x - width
    if x < -width:
        return x + width
    return 0.0 * x


def friction(load: Any, servo: Any) -> Any:
    """Dry friction f of (1) under ``load`` [rad], in rad."""
    return servo.level + servo.share * np.abs(load)


def next_rate(error: Any, rate: Any, load: Any, servo: Any, h: Any) -> Any:
    """Rate [rad/s] after one step (2) of ``h`` [s] from a position error [rad]."""
    stiff = h * h
    drive = error
    if np.abs(error) > servo.error_limit:
        stiff = 0.0
        drive = np.sign(error) * servo.error_limit
    push = servo.inertia * rate + h * (drive + load)
    resisted = soft_threshold(push, h * friction(load, servo))
    found = resisted / (servo.inertia + h * servo.damping + stiff)
    return min(max(found, -servo.speed_limit), servo.speed_limit)


def play(output: Any, drive: Any, gap: Any) -> Any:
    """(4): the output that a drive takes along through a clearance."""
    return min(max(output, drive - 0.5 * gap), drive + 0.5 * gap)
