"""Source of a periodic motion given as a Fourier series."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models.fourier_motion import FourierMotion
from . import scalars


class FourierSource(LeafSystem):
    """q_j(t) = sum_k c_jk (cos(k w t) - 1) + s_jk sin(k w t), w = 2 pi/period, of ``FourierMotion``.

    | port | size | unit |
    |---|---|---|
    | out `position`     | n | rad |
    | out `velocity`     | n | rad/s |
    | out `acceleration` | n | rad/s^2 |

    No state; the outputs are functions of the Context's time. Numeric parameters: ``COSINE`` and
    ``SINE`` (n K,) [rad], row by row, and ``PERIOD`` (1,) [s]. Raises ValueError on evaluation if they
    do not make a ``FourierMotion``.
    """

    COSINE, SINE, PERIOD = range(3)

    def __init__(self, motion: FourierMotion) -> None:
        LeafSystem.__init__(self)
        self._motion = motion
        scalars.declare_parameter(self, np.ravel(motion.cosine))
        scalars.declare_parameter(self, np.ravel(motion.sine))
        scalars.declare_parameter(self, [motion.period])
        for derivative, name in enumerate(("position", "velocity", "acceleration")):
            self.DeclareVectorOutputPort(
                name,
                motion.shafts,
                self._derivative(derivative),
                prerequisites_of_calc={self.time_ticket(), self.all_parameters_ticket()},
            )

    def _derivative(self, order: int) -> Any:
        def table(context: Any, which: int) -> tuple[tuple[float, ...], ...]:
            values = np.asarray(context.get_numeric_parameter(which).value())
            return tuple(map(tuple, values.reshape(self._motion.shafts, -1)))

        def calc(context: Any, output: Any) -> None:
            motion = FourierMotion(
                name=self._motion.name,
                period=context.get_numeric_parameter(self.PERIOD)[0],
                cycles=self._motion.cycles,
                cosine=table(context, self.COSINE),
                sine=table(context, self.SINE),
            )
            output.SetFromVector(np.asarray(motion.sample(context.get_time())[order]))

        return calc
