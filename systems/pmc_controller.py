"""A sampled controller of the PepperMill-Carrier."""

from typing import Any

import numpy as np
from pydrake.systems.framework import LeafSystem

from ..models.pmc import control
from ..models.pmc.control import Controller, Target
from .pmc_source import PORTS


class CarrierController(LeafSystem):
    """Task-space PD, joint PD, computed torque or resolved acceleration, see ``models.pmc.control``.

    | port | size | unit |
    |---|---|---|
    | in  `measured`           | 4 | rad, motor angles from home |
    | in  `joints`             | 4 | m, m, rad, rad: reference |
    | in  `joint_acceleration` | 4 | per s^2 |
    | in  `pose`               | 4 | m, m, m, rad: reference |
    | in  `pose_acceleration`  | 4 | per s^2 |
    | out `torque`             | 4 | N m, motors (L1, R1, L2, R2), limited |

    Discrete state every ``period`` seconds: low-passed errors and joints. Wakes up at rest on initialisation. The
    output depends on the inputs of the same sample.
    Raises ValueError if ``period`` is not positive.
    """

    def __init__(self, controller: Controller, period: float) -> None:
        LeafSystem.__init__(self)
        if not period > 0.0:
            raise ValueError(f"CarrierController: period is {period}; expected a positive time [s]")
        self.controller = controller
        self.DeclareDiscreteState(20)
        for name in ("measured", *PORTS):
            self.DeclareVectorInputPort(name, 4)
        self.DeclareVectorOutputPort("torque", 4, self._torque)
        self.DeclareInitializationDiscreteUpdateEvent(self._wake_up)
        self.DeclarePeriodicDiscreteUpdateEvent(period, 0.0, self._move_on)

    def _wake_up(self, context: Any, discrete_state: Any) -> None:
        memory = np.zeros((5, 4))
        control.wake_up(self.GetInputPort("measured").Eval(context), self.controller, memory)
        discrete_state.set_value(memory.ravel())

    def _torque(self, context: Any, output: Any) -> None:
        output.SetFromVector(self._sample(context)[0])

    def _move_on(self, context: Any, discrete_state: Any) -> None:
        discrete_state.set_value(self._sample(context)[1].ravel())

    def _sample(self, context: Any) -> tuple[Any, Any]:
        memory = np.array(context.get_discrete_state_vector().value()).reshape(5, 4)
        target = Target(*(self.GetInputPort(name).Eval(context) for name in PORTS))
        torque = np.zeros(4)
        control.step(
            target, self.GetInputPort("measured").Eval(context), self.controller, memory, torque
        )
        return torque, memory
