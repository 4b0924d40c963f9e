"""Source of a path of the tool."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ...models.paths import Path


class PathSource(LeafSystem):
    """A path over time, ``models.paths``: x_0(t) and its derivatives.

    | port | size | unit |
    |---|---|---|
    | out `position`     | n | m or rad, task coordinates |
    | out `velocity`     | n | the same per s |
    | out `acceleration` | n | the same per s^2 |

    No state; the outputs are functions of the Context's time.
    """

    def __init__(self, path: Path) -> None:
        LeafSystem.__init__(self)
        self.path = path
        size = np.size(path.sample(0.0)[0])
        for order, name in enumerate(("position", "velocity", "acceleration")):
            self.DeclareVectorOutputPort(
                name, size, self._derivative(order), prerequisites_of_calc={self.time_ticket()}
            )

    def _derivative(self, order: int) -> Any:
        def calc(context: Any, output: Any) -> None:
            output.SetFromVector(np.asarray(self.path.sample(context.get_time())[order]))

        return calc
