r"""The functions of ``elementary.py`` as loops are compiled with them.

.. math:: \tanh x = \mathrm{sgn}(x) \frac{-m}{2 + m}, \quad m = e^{-2|x|} - 1 = 2^k p(r) + 2^k - 1, \quad
   -2|x| = k \ln 2 + r, \; |r| \le \tfrac12 \ln 2

with the Taylor polynomial :math:`p(r) \approx e^r - 1` of degree 13, whose remainder is below 1e-17. Within 4 units in the last
place of the C library's, for floats and for lanes (``lanes.py``), which have an exponential and no branch, too.
"""

from math import factorial
from typing import Any

import numpy as np
from llvmlite import ir
from numba.core import types
from numba.extending import overload, register_jitable

from . import lanes
from .elementary import tanh, where, whole

LOG2_E = 1.4426950408889634
LN_2 = 0.6931471805599453
ROUND = (
    6755399441055744.0  # 1.5 2^52: what is added to it is rounded to an integer, in its low bits
)
SATURATED = 20.0  # from where on tanh is 1 in double precision
UNDERFLOW, OVERFLOW = -708.0, 709.0  # where the exponential leaves the normal numbers
C2, C3, C4, C5, C6, C7, C8, C9, C10, C11, C12, C13 = (1.0 / factorial(k) for k in range(2, 14))


OPTIONS: Any = {"forceinline": True, "error_model": "numpy", "fastmath": {"contract"}}


@lanes.intrinsic
def power_of_two(typing_context: Any, shifted: Any) -> Any:
    """2^k of k + ROUND: k from its low bits into the exponent of a double."""

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        number = arguments[0].type
        bits = (
            ir.IntType(64)
            if shifted == types.float64
            else ir.VectorType(ir.IntType(64), lanes.LANES)
        )
        constant = (
            (lambda n: ir.Constant(bits, n))
            if shifted == types.float64
            else (lambda n: ir.Constant(bits, [n] * lanes.LANES))
        )
        exponent = builder.add(builder.bitcast(arguments[0], bits), constant(1023))
        return builder.bitcast(builder.shl(exponent, constant(52)), number)

    return shifted(shifted), generate


@register_jitable(**OPTIONS)
def _exponential(y: Any) -> tuple[Any, Any]:
    """2^k and p(r), so that exp(y) = 2^k (1 + p)."""
    shifted = y * LOG2_E + ROUND
    r = y - (shifted - ROUND) * LN_2
    r2 = r * r
    r4 = r2 * r2
    low = (C2 + C3 * r) + (C4 + C5 * r) * r2
    middle = (C6 + C7 * r) + (C8 + C9 * r) * r2
    high = (C10 + C11 * r) + (C12 + C13 * r) * r2
    return power_of_two(shifted), r + r2 * (low + r4 * (middle + r4 * high))


@overload(tanh, jit_options=OPTIONS)
def _compiled_tanh(x: Any) -> Any:
    def by_library(x: Any) -> Any:
        return np.tanh(x)

    def of_float(x: Any) -> Any:
        if abs(x) > SATURATED:  # the processor guesses it right, and need not wait for the result
            return np.copysign(1.0, x)
        scale, p = _exponential(-2.0 * abs(x))
        m = scale * p + (scale - 1.0)
        return np.copysign(-m / (2.0 + m), x)

    def of_lanes(x: Any) -> Any:
        scale, p = _exponential(max(-2.0 * np.abs(x), -2.0 * SATURATED))
        m = scale * p + (scale - 1.0)
        return lanes.with_sign(-m / (2.0 + m), x)

    if x == lanes.lanes:
        return of_lanes
    return of_float if x == types.float64 else by_library


@overload(np.exp, jit_options=OPTIONS)
def _exponential_of_lanes(x: Any) -> Any:
    def of_lanes(x: Any) -> Any:
        scale, p = _exponential(min(max(x, UNDERFLOW), OVERFLOW))
        below = lanes.select(x < UNDERFLOW, 0.0 * scale, scale + scale * p)
        return lanes.select(x > OVERFLOW, np.inf + 0.0 * scale, below)

    return of_lanes if x == lanes.lanes else None


def _of_lanes(function: Any, implementation: Any) -> None:
    """Let a function of NumPy take lanes, too."""

    def of_lanes(x: Any) -> Any:
        return implementation(x)

    def choose(x: Any) -> Any:
        return of_lanes if x == lanes.lanes else None

    overload(function, jit_options=OPTIONS)(choose)


for _function, _implementation in (
    (np.abs, lanes.magnitude),
    (np.floor, lanes.rounded_down),
    (np.sqrt, lanes.square_root),
    (np.sin, lanes.sine),
    (np.cos, lanes.cosine),
):
    _of_lanes(_function, _implementation)


@overload(np.sign, jit_options=OPTIONS)
def _sign_of_lanes(x: Any) -> Any:
    def of_lanes(x: Any) -> Any:
        return lanes.select(x > 0.0, 1.0 + 0.0 * x, lanes.select(x < 0.0, -1.0 + 0.0 * x, x))

    return of_lanes if x == lanes.lanes else None


@overload(where, jit_options=OPTIONS)
def _compiled_where(condition: Any, a: Any, b: Any) -> Any:
    def of_floats(condition: Any, a: Any, b: Any) -> Any:
        return a if condition else b

    def of_lanes(condition: Any, a: Any, b: Any) -> Any:
        return lanes.select(condition, a, b)

    return of_lanes if condition == lanes.truths else of_floats


@overload(whole, jit_options=OPTIONS)
def _compiled_whole(x: Any) -> Any:
    def of_float(x: Any) -> Any:
        return int(np.floor(x))

    def of_lanes(x: Any) -> Any:
        return int(np.floor(lanes.first_lane(x)))

    return of_lanes if x == lanes.lanes else of_float
