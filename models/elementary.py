"""Elementary functions that laws call: on floats, AutoDiffXd and Expressions NumPy's and Python's.

Compiled for floats and for lanes they have forms of their own, ``elementary_compiled.py``.
"""

from typing import Any

import numpy as np


def tanh(x: Any) -> Any:
    """Hyperbolic tangent."""
    return np.tanh(x)


def where(condition: Any, a: Any, b: Any) -> Any:
    """``a`` where the condition holds, else ``b``; what an ``if`` cannot do for lanes."""
    return a if condition else b


def whole(x: Any) -> int:
    """The largest integer that is not above a float."""
    return int(np.floor(x))
