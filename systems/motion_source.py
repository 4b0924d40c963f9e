"""Source of a motion program."""

from typing import Any

from pydrake.systems.framework import LeafSystem

from ..models.motion import MotionProgram, cycle
from . import scalars


class MotionSource(LeafSystem):
    """Out-and-back cycles of the 4-5-6-7 polynomial, one amplitude per motor (eqs. 5.3-5.4).

    | port | size | unit |
    |---|---|---|
    | out `position`     | 2 | rad, motors (L, R) |
    | out `velocity`     | 2 | rad/s |
    | out `acceleration` | 2 | rad/s^2 |

    No state; the outputs are functions of the Context's time. Numeric parameters: ``AMPLITUDE`` (2,)
    [rad] and ``RATE`` (1,) [Hz]. Raises ValueError on evaluation if the rate is not positive.
    Source: Friedlaender 2015, section 5.1.4 and Table 5-2.
    """

    AMPLITUDE, RATE = range(2)

    def __init__(self, program: MotionProgram) -> None:
        LeafSystem.__init__(self)
        scalars.declare_parameter(self, [program.amplitude_L, program.amplitude_R])
        scalars.declare_parameter(self, [program.rate])
        for derivative, name in enumerate(("position", "velocity", "acceleration")):
            self.DeclareVectorOutputPort(
                name,
                2,
                self._derivative(derivative),
                prerequisites_of_calc={self.time_ticket(), self.all_parameters_ticket()},
            )

    def _derivative(self, order: int) -> Any:
        def calc(context: Any, output: Any) -> None:
            rate = context.get_numeric_parameter(self.RATE)[0]
            if not rate > 0.0:
                raise ValueError(f"MotionSource: rate is {rate} Hz; expected a positive number")
            amplitude = context.get_numeric_parameter(self.AMPLITUDE).value()
            output.SetFromVector(cycle(context.get_time(), rate)[order] * amplitude)

        return calc
