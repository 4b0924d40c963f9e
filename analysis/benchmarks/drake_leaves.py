"""LeafSystems of the closed loop whose laws are plain Python: what a Drake user writes first."""

from typing import Any

import numpy as np
from pydrake.systems.framework import BasicVector, LeafSystem

from . import peer_laws as laws
from .peer_laws import Constants


class SourceLeaf(LeafSystem):
    """Reference of the two shafts [rad], sampled."""

    def __init__(self, c: Constants, reference: Any) -> None:
        super().__init__()
        self._dt, self._reference = c.dt, reference
        self.DeclareVectorOutputPort("reference", 2, self._output)

    def _output(self, context: Any, output: Any) -> None:
        k = round(context.get_time() / self._dt)
        output.SetFromVector(self._reference[min(k, len(self._reference) - 1)])


class PDLeaf(LeafSystem):
    """PD with the filtered derivative; its state is the low-passed error."""

    def __init__(self, c: Constants) -> None:
        super().__init__()
        self._c = c
        self._reference: Any = self.DeclareVectorInputPort("reference", 2)
        self._measured: Any = self.DeclareVectorInputPort("measured", 2)
        self._state = self.DeclareDiscreteState(2)
        self.DeclareVectorOutputPort("command", 2, self._output)
        self.DeclarePeriodicDiscreteUpdateEvent(c.dt, 0.0, self._update)

    def _error(self, context: Any) -> Any:
        return laws.difference(self._reference.Eval(context), self._measured.Eval(context))

    def _output(self, context: Any, output: Any) -> None:
        low = context.get_discrete_state(self._state).value()
        output.SetFromVector(laws.pd(self._c, self._error(context), low))

    def _update(self, context: Any, state: Any) -> None:
        low = context.get_discrete_state(self._state).value()
        state.set_value(self._state, laws.low_pass(self._c, self._error(context), low))


class PlantLeaf(LeafSystem):
    """The C-drive, one ODE4 step a sample under the held torque [N m]."""

    def __init__(self, c: Constants) -> None:
        super().__init__()
        self._c = c
        self._torque: Any = self.DeclareVectorInputPort("torque", 2)
        self._state = self.DeclareDiscreteState(4)
        self.DeclareVectorOutputPort("angle", 2, self._output, {self.xd_ticket()})
        self.DeclarePeriodicDiscreteUpdateEvent(c.dt, 0.0, self._update)

    def _output(self, context: Any, output: Any) -> None:
        output.SetFromVector(context.get_discrete_state(self._state).value()[:2])

    def _update(self, context: Any, state: Any) -> None:
        before = context.get_discrete_state(self._state).value()
        after = laws.ode4_step(self._c, before, self._torque.Eval(context))
        state.set_value(self._state, np.array(after))


class EncoderLeaf(LeafSystem):
    """What the encoders read [rad]."""

    def __init__(self, c: Constants) -> None:
        super().__init__()
        self._c = c
        self._angle: Any = self.DeclareVectorInputPort("angle", 2)
        self.DeclareVectorOutputPort("measured", BasicVector(2), self._output)

    def _output(self, context: Any, output: Any) -> None:
        output.SetFromVector(laws.read_encoder(self._c, self._angle.Eval(context)))
