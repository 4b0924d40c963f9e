"""Compiled fixed-step loop of ``stick_slip.py``."""

from typing import Any

import numpy as np

from . import compilation, stick_slip

compilation.register_laws(*stick_slip.LAW_MODULES, stick_slip)


@compilation.kernel
def play(
    pieces: Any,
    steps: int,
    load: float,
    actuator: Any,
    every: int,
    time: Any,
    states: Any,
    final: Any,
) -> Any:
    """Net motion per period from state ``final``, which becomes the last one.

    Every ``every``-th state goes into ``states`` (0 keeps none). ``pieces`` (n, 4) of one
    period: start [V], slope [V/s], time step [s], number of time steps.
    """
    state = (
        final[0],
        final[1],
        final[2],
        final[3],
        final[4],
        final[5],
        final[6],
        final[7],
    )
    motion = np.empty(steps)
    elapsed = 0.0
    done = 0
    for step in range(steps):
        before = state[2]
        for piece in range(pieces.shape[0]):
            voltage, slope, h = pieces[piece, 0], pieces[piece, 1], pieces[piece, 2]
            count = int(pieces[piece, 3])
            for i in range(count):
                state = _advance(state, voltage + slope * (i * h), slope, h, load, actuator)
                done += 1
                if every > 0 and done % every == 0:
                    time[done // every] = elapsed + (i + 1) * h
                    for j in range(8):
                        states[done // every, j] = state[j]
            elapsed += count * h
        motion[step] = state[2] - before
    for j in range(8):
        final[j] = state[j]
    return motion


@compilation.part
def _advance(state: Any, voltage: float, slope: float, h: float, load: float, actuator: Any) -> Any:
    k1 = stick_slip.derivatives(state, voltage, slope, load, actuator)
    middle = voltage + 0.5 * h * slope
    k2 = stick_slip.derivatives(_along(state, 0.5 * h, k1), middle, slope, load, actuator)
    k3 = stick_slip.derivatives(_along(state, 0.5 * h, k2), middle, slope, load, actuator)
    k4 = stick_slip.derivatives(_along(state, h, k3), voltage + h * slope, slope, load, actuator)
    w = h / 6.0
    return (
        state[0] + w * (k1[0] + 2.0 * (k2[0] + k3[0]) + k4[0]),
        state[1] + w * (k1[1] + 2.0 * (k2[1] + k3[1]) + k4[1]),
        state[2] + w * (k1[2] + 2.0 * (k2[2] + k3[2]) + k4[2]),
        state[3] + w * (k1[3] + 2.0 * (k2[3] + k3[3]) + k4[3]),
        state[4] + w * (k1[4] + 2.0 * (k2[4] + k3[4]) + k4[4]),
        state[5] + w * (k1[5] + 2.0 * (k2[5] + k3[5]) + k4[5]),
        state[6] + w * (k1[6] + 2.0 * (k2[6] + k3[6]) + k4[6]),
        state[7] + w * (k1[7] + 2.0 * (k2[7] + k3[7]) + k4[7]),
    )


@compilation.part
def _along(state: Any, h: float, rate: Any) -> Any:
    return (
        state[0] + h * rate[0],
        state[1] + h * rate[1],
        state[2] + h * rate[2],
        state[3] + h * rate[3],
        state[4] + h * rate[4],
        state[5] + h * rate[5],
        state[6] + h * rate[6],
        state[7] + h * rate[7],
    )
