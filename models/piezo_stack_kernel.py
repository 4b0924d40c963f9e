"""Compiled loop over ``piezo_stack.py``: the length that a command asks for."""

from typing import Any

import numpy as np

from . import compilation, hysteresis, piezo_stack

compilation.register_laws(hysteresis, piezo_stack)

SMALL = 0.1  # change of the drive, times Bouc-Wen's beta + |gamma|, that one step may take


@compilation.kernel
def simulate(t: Any, command: Any, stack: Any, decades: Any, out: Any) -> None:
    """Length ``out`` (samples,) [um] under a command (samples,) [V] at times (samples,) [s]."""
    elements = np.zeros(stack.limits.size)
    creep = np.full(decades.size, stack.before)
    first = second = drive = effective = stack.before
    seen, lost, previous = 0, 0.0, stack.before
    for k in range(t.size):
        when = t[k] - stack.delay
        while seen < t.size - 2 and t[seen + 1] <= when:
            seen += 1
        if when < t[0]:
            wanted = stack.before
        else:
            share = (when - t[seen]) / (t[seen + 1] - t[seen])
            wanted = command[seen] + min(share, 1.0) * (command[seen + 1] - command[seen])
        wanted = min(max(wanted, stack.low), stack.high)
        if k == 0:
            h, start = 0.0, wanted  # it has just been switched on
        else:
            h, start = t[k] - t[k - 1], previous
        previous = wanted
        lag = stack.lag / stack.stages
        if h > 0.0 or lag <= 0.0:
            was = first
            first = piezo_stack.lag_step(first, start, wanted, lag, h)
            second = piezo_stack.lag_step(second, was, first, lag, h)
        voltage = first if stack.stages == 1 else second
        change = voltage - drive
        drive = voltage
        if stack.alpha != 0.0:
            pace = np.abs(change) * (stack.beta + np.abs(stack.gamma)) / SMALL
            parts = 1 + int(min(pace, 100.0))
            for _ in range(parts):
                lost = hysteresis.bouc_wen_step(
                    lost, change / parts, stack.alpha, stack.beta, stack.gamma
                )
        total = lost
        for i in range(stack.limits.size):
            elements[i] = hysteresis.stop(elements[i], change, stack.limits[i])
            total += stack.shares[i] * elements[i]
        was = effective
        effective = voltage - total
        crept = 0.0
        for j in range(decades.size):
            if h > 0.0:
                creep[j] = piezo_stack.lag_step(creep[j], was, effective, decades[j], h)
            crept += creep[j]
        out[k] = piezo_stack.length(effective, crept, t[k], stack)
