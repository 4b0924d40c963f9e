"""Arrays of known size, and the elementary functions of compiled loops."""

import numba
import numpy as np
import pytest

from gapscope.models import elementary, lanes, stack
from gapscope.models import elementary_compiled as elementary_compiled


@numba.njit
def tanh_of_each(x, out):
    for i in range(x.size):
        out[i] = elementary.tanh(x[i])


def test_tanh_is_that_of_the_library_to_four_last_places():
    rng = np.random.default_rng(3)
    x = np.concatenate([scale * rng.normal(size=20_000) for scale in (1e-9, 1e-3, 0.3, 2.0, 20.0)])
    out = np.empty_like(x)
    tanh_of_each(x, out)
    exact = np.tanh(x.astype(np.longdouble))
    places = np.abs(out - exact) / np.spacing(np.abs(exact.astype(float)))
    assert np.max(places) < 4.0


def test_tanh_at_the_ends():
    x = np.array([0.0, -0.0, np.inf, -np.inf, np.nan, 20.0, -25.0, 1e308, 5e-324])
    out = np.empty_like(x)
    tanh_of_each(x, out)
    np.testing.assert_array_equal(out, np.tanh(x))
    assert np.signbit(out[1])


@numba.njit(error_model="numpy")
def functions_in_lanes(x, y, out):
    x, y, out = lanes.in_lanes(x), lanes.in_lanes(y), lanes.in_lanes(out)
    for i in range(x.size):
        a, b = x[i], y[i]
        out[i, 0], out[i, 1] = elementary.tanh(a), np.exp(b)
        out[i, 2], out[i, 3] = np.abs(a) + 2 * b / 3, np.sign(a) * np.sin(b) + np.cos(b)
        out[i, 4], out[i, 5] = np.floor(a), np.sqrt(np.abs(b)) - b
        out[i, 6] = min(max(a, -0.5), 0.5)
        out[i, 7] = elementary.where(a > 0.0, b, 3.0) + elementary.where(a <= 0.5, 1.0, a)


def test_functions_of_lanes_are_those_of_numpy():
    rng = np.random.default_rng(4)
    x, y = (scale * rng.normal(size=(3000, lanes.LANES)) for scale in (1.5, 200.0))
    x[0, :5] = 0.0, -0.0, 30.0, -1e9, 0.5
    out = np.empty((len(x), 8, lanes.LANES))
    functions_in_lanes(x, y, out)
    with np.errstate(over="ignore"):
        exponential = np.exp(y)
    exact = (
        np.tanh(x),
        exponential,
        np.abs(x) + 2 * y / 3,
        np.sign(x) * np.sin(y) + np.cos(y),
        np.floor(x),
        np.sqrt(np.abs(y)) - y,
        np.clip(x, -0.5, 0.5),
        np.where(x > 0.0, y, 3.0) + np.where(x <= 0.5, 1.0, x),
    )
    for j, values in enumerate(exact):
        # The exponential reduces its argument once: its last place counts up to |y| times.
        rtol = 5e-16 * np.max(np.abs(y)) if j == 1 else 1e-15
        np.testing.assert_allclose(out[:, j], values, rtol=rtol, atol=1e-300, err_msg=str(j))


@numba.njit(error_model="numpy")
def effects_of(x):
    x = lanes.in_lanes(x)
    return [(a != 0.0, a == 0.0, elementary.whole(a)) for a in (x[0], x[1], x[2])]


def test_an_effect_of_any_lane_counts():
    """NaN, too, differs from zero."""
    x = np.zeros((3, lanes.LANES))
    x[1, 7], x[2] = 1e-300, np.nan
    x[2, 0] = 2.5
    assert effects_of(x) == [(False, True, 0), (True, False, 0), (True, False, 2)]


def test_no_law_branches_on_single_lanes():
    @numba.njit
    def law(x):
        return 1.0 if lanes.in_lanes(x)[0] > 0.0 else 0.0

    with pytest.raises(numba.core.errors.TypingError, match="truths"):
        law(np.zeros((1, lanes.LANES)))


@numba.njit
def filled(rows, columns):
    like = np.zeros(1)
    a, b = stack.matrix(rows, columns, like), stack.vector(rows, like)
    none = stack.vector((), like)
    for i in range(a.shape[0]):
        b[i] += i
        for j in range(a.shape[1]):
            a[i, j] += 10.0 * i + j
    return a.copy(), b.copy(), none.size


def test_stack_arrays_are_zeros_of_the_sizes_of_tuples():
    for run in (filled, filled.py_func):
        a, b, size = run(stack.axis(2), stack.axis(3))
        np.testing.assert_array_equal(a, [[0.0, 1.0, 2.0], [10.0, 11.0, 12.0]])
        np.testing.assert_array_equal(b, [0.0, 1.0])
        assert size == 0
