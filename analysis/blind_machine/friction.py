"""Dry friction as a set-valued law, solved by time stepping (Moreau 1988), not by a smoothed sign.

Over a step h each contact transmits an impulse within ``[-h limit_backward, h limit_forward]``
that brings its sliding velocity to zero if it can: stiction and sliding without a regularisation.
Limits may fall with speed by a rational curve, grow with the transmitted load and fade as the machine warms up.
Before sliding, four elasto-plastic elements in parallel (Maxwell slip) may take the contact's place.
"""

import numba

from .motion import Array

SWEEPS = 12  # the two screws' coupling halves the error at each sweep
ELEMENTS = 4


@numba.njit(cache=True)
def falling(speed: float, ratio: float, speed_s: float) -> float:
    """Sliding limit over its high-speed value: ``1 + (ratio - 1)/(1 + (v/v_s)^2)``."""
    return 1.0 + (ratio - 1.0) / (1.0 + (speed / speed_s) ** 2)


@numba.njit(cache=True)
def clip(value: float, low: float, high: float) -> float:
    """``value`` within ``[low, high]``."""
    return min(max(value, low), high)


@numba.njit(cache=True)
def slide_two(
    velocity: Array,
    inverse_inertia: Array,
    directions: Array,
    lower: Array,
    upper: Array,
    impulse: Array,
) -> None:
    """Gauss-Seidel over contacts acting on a diagonal two-coordinate inertia; updates in place."""
    for _ in range(SWEEPS):
        for i in range(directions.shape[0]):
            a, b = directions[i, 0], directions[i, 1]
            mobility = a * a * inverse_inertia[0] + b * b * inverse_inertia[1]
            sliding = a * velocity[0] + b * velocity[1]
            wanted = clip(impulse[i] + sliding / mobility, lower[i], upper[i])
            change = wanted - impulse[i]
            impulse[i] = wanted
            velocity[0] -= inverse_inertia[0] * a * change
            velocity[1] -= inverse_inertia[1] * b * change


@numba.njit(cache=True)
def maxwell_slip(elements: Array, step: float, reach: float, limit: float) -> float:
    """Force of elements with equal shares of ``limit`` that yield at reach/4, ... reach; moves them by ``step``."""
    force = 0.0
    for j in range(ELEMENTS):
        yield_at = reach * (j + 1) / ELEMENTS
        elements[j] = clip(elements[j] + step, -yield_at, yield_at)
        force += limit / ELEMENTS * elements[j] / yield_at
    return force
