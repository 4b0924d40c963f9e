r"""Chebyshev series of several variables, compiled: :math:`f(x) = \sum_k c_k T_{k_1}(x_1) T_{k_2}(x_2) \ldots`.

Interpolation in the Chebyshev nodes; for smooth functions its error falls geometrically with their number (Trefethen
2013, Approximation Theory and Approximation Practice, chs. 2 and 8). Variables are scaled to -1..1.
"""

from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import compilation

Floats = NDArray[np.float64]


def grid(nodes: int, variables: int) -> Floats:
    """Nodes (nodes ** variables, variables) at which a function is to be known, the first variable slowest."""
    line = np.cos(np.pi * (np.arange(nodes) + 0.5) / nodes)
    return np.array(list(product(line, repeat=variables)))


def series(values: Floats, nodes: int) -> Floats:
    """Coefficients (points, columns) of functions by their values (points, columns) on ``grid``."""
    variables = round(np.log(len(values)) / np.log(nodes))
    into = np.cos(np.pi * np.outer(np.arange(nodes), np.arange(nodes) + 0.5) / nodes) * 2.0 / nodes
    into[0] *= 0.5
    found = values.reshape(*(nodes,) * variables, -1)
    for axis in range(variables):
        found = np.moveaxis(np.tensordot(into, found, (1, axis)), 0, axis)
    return np.ascontiguousarray(found.reshape(len(values), -1))


@compilation.kernel
def evaluate(coefficients: Any, nodes: int, x: Any) -> Any:
    """Values (columns,) of series at x (variables,), inside -1..1 or not far outside."""
    columns = coefficients.shape[1]
    present, size = coefficients, coefficients.shape[0]
    for j in range(x.size):
        size //= nodes
        found = np.zeros((size, columns))
        before, now = x[j], 1.0  # T_-1 and T_0
        for k in range(nodes):
            for i in range(size):
                for c in range(columns):
                    found[i, c] += now * present[k * size + i, c]
            before, now = now, 2.0 * x[j] * now - before
        present = found
    return present[0]
