"""A joint on a position servo as a block of a diagram."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models import position_servo
from ..models.position_servo import PositionServo
from . import scalars


class ServoJoint(LeafSystem):
    r"""One implicit step of :math:`a\ddot q = \mathrm{sat}(r - q) + g - T\dot q - f\,\mathrm{sgn}\,\dot q` a sample.

    The law of ``models.position_servo``, torques over the servo's stiffness.

    | port | size | unit |
    |---|---|---|
    | in  `reference` | 1 | rad |
    | in  `load`      | 1 | rad, torque over stiffness |
    | out `angle`     | 1 | rad, as measured: behind the clearance, with the errors of its sensor |
    | out `rate`      | 1 | rad/s, of the servo |

    Discrete state every ``period`` seconds: servo angle, measured side of the clearance, rate, lagged reference; at rest
    at ``start``, a measured angle [rad]. Raises ValueError for a period that is not positive, and for a servo with a
    delay: that is a block of its own before `reference`.
    """

    def __init__(self, servo: PositionServo, period: float, start: float = 0.0) -> None:
        LeafSystem.__init__(self)
        if servo.delay != 0.0:
            raise ValueError(
                f"ServoJoint: delay is {servo.delay} s; expected 0, with a delay block"
            )
        self.servo, self.period = servo, scalars.positive(self, "period", period, "s")
        self.keep = 1.0 - np.exp(-period / servo.lag) if servo.lag > 0.0 else 1.0
        for name in ("reference", "load"):
            self.DeclareVectorInputPort(name, 1)
        at = (start - servo.zero) / (1.0 + servo.scale_error)
        self.DeclareDiscreteState(np.array([at, at, 0.0, start]))
        for name, calc in (("angle", self._angle), ("rate", self._rate)):
            self.DeclareVectorOutputPort(name, 1, calc, prerequisites_of_calc={self.xd_ticket()})
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._update)

    def _angle(self, context: Any, output: Any) -> None:
        y = context.get_discrete_state_vector().value()[1]
        output.SetFromVector([(1.0 + self.servo.scale_error) * y + self.servo.zero])

    def _rate(self, context: Any, output: Any) -> None:
        output.SetFromVector(context.get_discrete_state_vector().value()[2:3])

    def _update(self, context: Any, discrete_state: Any) -> None:
        q, y, rate, asked = context.get_discrete_state_vector().value()
        (wanted,), (load,) = (scalars.signal(self, context, n) for n in ("reference", "load"))
        asked += self.keep * (wanted - asked)
        rate = position_servo.next_rate(asked - q, rate, load, self.servo, self.period)
        q += self.period * rate
        y = position_servo.play(y, q, self.servo.gap)
        discrete_state.set_value(np.array([q, y, rate, asked]))
