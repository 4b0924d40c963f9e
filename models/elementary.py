"""Elementary functions that laws call: NumPy's, on floats, AutoDiffXd and Expressions.

Compiled for floats they have a form of their own, ``elementary_compiled.py``.
"""

from typing import Any

import numpy as np


def tanh(x: Any) -> Any:
    """Hyperbolic tangent."""
    return np.tanh(x)
