"""Compiled loop over ``piezo_stack.py``: the length that a command asks for."""

from typing import Any

import numpy as np

from . import compilation, hysteresis, piezo_stack

compilation.register_laws(hysteresis, piezo_stack)

SMALL = 0.1  # change of the drive, times Bouc-Wen's beta + |gamma|, that one step may take

# The memory of a stack beside its stop elements and its creep.
(
    ASKED,  # command that has passed the limit [V]
    FIRST,  # behind the amplifier's first stage [V]
    SECOND,  # behind its second stage [V]
    DRIVE,  # at the ceramic [V]
    LOST,  # to Bouc-Wen's hysteresis [V]
    EFFECTIVE,  # [V]
) = range(6)


@compilation.kernel
def at_rest(stack: Any, decades: Any) -> Any:
    """Memory (6,), stop elements (k,) and creep (decades,) under the command before the first sample."""
    memory = np.full(6, stack.before)
    memory[LOST] = 0.0
    return memory, np.zeros(stack.limits.size), np.full(decades.size, stack.before)


@compilation.kernel
def advance(
    command: float,
    h: float,
    time: float,
    stack: Any,
    decades: Any,
    memory: Any,
    elements: Any,
    creep: Any,
) -> float:
    """Length [um] at ``time``, ``h`` seconds after the last sample, as the command moves evenly to ``command`` [V].

    Changes memory, elements and creep. With h = 0 the command is there at once: it has just been switched on.
    """
    wanted = min(max(command, stack.low), stack.high)
    start = memory[ASKED] if h > 0.0 else wanted
    memory[ASKED] = wanted
    lag = stack.lag / stack.stages
    if h > 0.0 or lag <= 0.0:
        was = memory[FIRST]
        memory[FIRST] = piezo_stack.lag_step(was, start, wanted, lag, h)
        memory[SECOND] = piezo_stack.lag_step(memory[SECOND], was, memory[FIRST], lag, h)
    voltage = memory[FIRST] if stack.stages == 1 else memory[SECOND]
    change = voltage - memory[DRIVE]
    memory[DRIVE] = voltage
    if stack.alpha != 0.0:
        pace = np.abs(change) * (stack.beta + np.abs(stack.gamma)) / SMALL
        parts = 1 + int(min(pace, 100.0))
        for _ in range(parts):
            memory[LOST] = hysteresis.bouc_wen_step(
                memory[LOST], change / parts, stack.alpha, stack.beta, stack.gamma
            )
    total = memory[LOST]
    for i in range(stack.limits.size):
        elements[i] = hysteresis.stop(elements[i], change, stack.limits[i])
        total += stack.shares[i] * elements[i]
    was = memory[EFFECTIVE]
    memory[EFFECTIVE] = voltage - total
    crept = 0.0
    for j in range(decades.size):
        if h > 0.0:
            creep[j] = piezo_stack.lag_step(creep[j], was, memory[EFFECTIVE], decades[j], h)
        crept += creep[j]
    return piezo_stack.length(memory[EFFECTIVE], crept, time, stack)


@compilation.kernel
def simulate(t: Any, command: Any, stack: Any, decades: Any, out: Any) -> None:
    """Length ``out`` (samples,) [um] under a command (samples,) [V] at times (samples,) [s]."""
    memory, elements, creep = at_rest(stack, decades)
    seen = 0
    for k in range(t.size):
        when = t[k] - stack.delay
        while seen < t.size - 2 and t[seen + 1] <= when:
            seen += 1
        if when < t[0]:
            wanted = stack.before
        else:
            share = (when - t[seen]) / (t[seen + 1] - t[seen])
            wanted = command[seen] + min(share, 1.0) * (command[seen + 1] - command[seen])
        h = t[k] - t[k - 1] if k > 0 else 0.0
        out[k] = advance(wanted, h, t[k], stack, decades, memory, elements, creep)
