"""The closed loop for many parameter sets in JAX: ``vmap`` over the sets of a ``scan`` over the samples."""

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import peer_laws as laws
from .peer_laws import Constants


def batch(
    c: Constants, reference: NDArray[np.float64], table: NDArray[np.float64]
) -> Callable[[], NDArray[np.float64]]:
    """Tracking errors (sets,) [rad RMS] of the sets in ``table`` (sets, 6), in double precision.

    ``table`` has the first six fields of ``Constants``. Raises ImportError without JAX.
    """
    import jax
    from jax import numpy as jnp

    def one(row: Any, wanted: Any) -> Any:
        machine = Constants._make([*row, *c[6:]])

        def sample(carry: Any, target: Any) -> Any:
            x, low, squares = carry
            error = laws.difference(target, x)
            torque = laws.pd(c, error, low)
            after = laws.ode4_step(machine, x, torque, jnp.tanh)
            squares = squares + error[0] ** 2 + error[1] ** 2
            return (jnp.stack(after), jnp.stack(laws.low_pass(c, error, low)), squares), None

        start = (jnp.zeros(4), jnp.zeros(2), jnp.zeros(()))
        (_, _, squares), _ = jax.lax.scan(sample, start, wanted)
        return jnp.sqrt(squares / wanted.size)

    compiled = jax.jit(jax.vmap(one, in_axes=(0, None)))

    def run() -> NDArray[np.float64]:
        with jax.enable_x64(True):
            return np.asarray(compiled(jnp.asarray(table), jnp.asarray(reference)))

    return run
