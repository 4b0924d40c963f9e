"""Arrays of known size, and the elementary functions of compiled loops."""

import numba
import numpy as np

from gapscope.models import elementary, stack
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


@numba.njit
def filled(rows, columns):
    a, b, none = stack.matrix(rows, columns), stack.vector(rows), stack.vector(())
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
