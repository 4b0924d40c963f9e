r"""A piezo stack in open loop, from commanded voltage to measured length.

1. amplifier: the command u passes a delay, a limit and a lag of one or two equal stages;
2. ceramic: :math:`w = V - v`, less the voltage v lost to hysteresis, ``hysteresis.py``;
3. length: :math:`y = y_0 + d(w + c\,(w - V_m)^2 + \kappa\sum_j w_j)`, with curvature c about the middle
   of the commanded span and creep :math:`T_j\dot w_j = w - w_j`, T = 1, 10 and 100 s: equal shares of
   a decade each, together the logarithmic creep of poled ceramics (Kuhnen 2003);
4. drift: what the sensor adds per second.

The stack is at rest under the command before its first sample. Not modelled: the stage's resonance,
load on the stack, hysteresis that depends on the rate.
"""

from typing import Any, NamedTuple

import numpy as np

DECADES = (1.0, 10.0, 100.0)  # T of the creep [s]


class PiezoStack(NamedTuple):
    """Constants of a stack, its amplifier and its sensor."""

    gain: float  # d [um/V]
    offset: float  # y_0 [um]
    before: float  # command before the first sample [V]
    limits: Any  # (k,) r of the stop elements [V]
    shares: Any  # (k,) a of the stop elements [-]
    alpha: float  # of Bouc-Wen [-]
    beta: float  # [1/V]
    gamma: float  # [1/V]
    curvature: float  # c [1/V]
    middle: float  # V_m [V]
    creep: float  # kappa, share of the length per decade of time [-]
    drift: float  # [um/s]
    low: float  # smallest voltage delivered [V]
    high: float  # largest voltage delivered [V]
    lag: float  # time constant of all stages together [s]
    stages: int  # 1 or 2
    delay: float  # [s]


def linear_stack(gain: float, offset: float, before: float) -> PiezoStack:
    """A stack whose length is proportional to the voltage."""
    return PiezoStack(
        gain=gain, offset=offset, before=before, limits=np.zeros(0), shares=np.zeros(0), alpha=0.0,
        beta=0.0, gamma=0.0, curvature=0.0, middle=0.0, creep=0.0, drift=0.0, low=-np.inf,
        high=np.inf, lag=0.0, stages=1, delay=0.0,
    )  # fmt: skip


def lag_step(state: Any, start: Any, end: Any, lag: Any, h: Any) -> Any:
    """First-order lag after ``h`` seconds of an input that moves evenly from start to end; exact."""
    if lag <= 0.0:
        return end
    behind = (end - start) / h * lag
    return end - behind + (state - start + behind) * np.exp(-h / lag)


def length(effective: Any, crept: Any, t: Any, stack: Any) -> Any:
    """Length (3), (4) [um] at the effective voltage w and the sum of the creep states [V]."""
    bent = stack.curvature * (effective - stack.middle) * (effective - stack.middle)
    return stack.offset + stack.drift * t + stack.gain * (effective + bent + stack.creep * crept)
