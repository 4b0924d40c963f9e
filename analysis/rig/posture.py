"""A parallel machine's terms over a box of postures as Chebyshev series: fast enough for real time whatever the machine."""

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...models import chebyshev
from ...models.parallel.machine import ParallelMachine
from ..gap.chain_machine import tables

Floats = NDArray[np.float64]
NODES = {1: 10, 2: 10, 3: 8}  # of a joint, by the number of joints


class Posture:
    """Terms of the weighted parts of a machine on its motors' shafts; joints = home + per_motor * motors.

    ``weights`` is by part, in the order of ``machine.parts()``. Raises ValueError where the box of ``home`` +- ``reach``
    (joints,) holds a posture that the machine does not have.
    """

    def __init__(
        self,
        machine: ParallelMachine,
        weights: ArrayLike,
        per_motor: float,
        home: Floats,
        reach: float,
    ) -> None:
        self._scale, self._nodes = per_motor / reach, NODES[len(home)]
        joints = home + reach * chebyshev.grid(self._nodes, len(home))
        found = tables(machine, joints, per_motor)
        weighted = [np.einsum("p,sp...->s...", np.asarray(weights), term) for term in found]
        values = np.concatenate([term.reshape(len(joints), -1) for term in weighted], axis=1)
        known = np.isfinite(values).all(axis=1)
        if not known.all():
            raise ValueError(
                f"no posture of the machine has joints {joints[~known][0].tolist()}; expected a smaller box"
            )
        self._series = chebyshev.series(values, self._nodes)

    def at(self, motors: Floats) -> tuple[Floats, Floats, Floats]:
        """Inertia (n, n) [kg m^2], velocity terms (n, n, n) [kg m^2] and weight (n,) [N m] at motor angles (n,) [rad]."""
        n = len(motors)
        found = chebyshev.evaluate(self._series, self._nodes, self._scale * motors)
        square, cube = n * n, n * n + n**3
        return found[:square].reshape(n, n), found[square:cube].reshape(n, n, n), found[cube:]
