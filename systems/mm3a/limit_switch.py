"""The audio limit switch as a system behind the stepper."""

from typing import Any

import numpy as np
from pydrake.systems.framework import BasicVector, EventStatus, LeafSystem

from ...models.mm3a.limit_switch import LOOP
from ...models.mm3a.step_size import STEP_TIME

JOINTS = 3


class AudioLimitSwitch(LeafSystem):
    """Tells a joint at its end stop by the sound of its last steps (section 4.1.2).

    A joint is reported when its recording of ``loop`` steps is complete and any of them ran against the stop;
    the next complete recording without one clears it.

    | port | size | unit |
    |---|---|---|
    | in  `stopped`  | 3 | 1 where the last step ran against a stop |
    | in  `taken`    | 3 | steps since the start |
    | out `detected` | 3 | 1 while the last complete recording has the sound of a stop |

    Discrete state of 9, updated every ``STEP_TIME`` just after the stepper: what is heard in the present
    recording, what is reported, steps at the last update. Raises ValueError if ``loop`` < 1.
    """

    def __init__(self, loop: int = LOOP) -> None:
        super().__init__()
        if loop < 1:
            raise ValueError(f"limit switch: loop is {loop} steps; expected at least 1")
        self._loop = loop
        self._stopped = self.DeclareVectorInputPort("stopped", BasicVector(JOINTS))
        self._taken = self.DeclareVectorInputPort("taken", BasicVector(JOINTS))
        self._heard = self.DeclareDiscreteState(np.zeros(JOINTS))
        self._detected = self.DeclareDiscreteState(np.zeros(JOINTS))
        self._counted = self.DeclareDiscreteState(np.zeros(JOINTS))
        self.DeclareStateOutputPort("detected", self._detected)
        self.DeclarePeriodicDiscreteUpdateEvent(STEP_TIME, 0.5 * STEP_TIME, self._update)

    def _update(self, context: Any, discrete: Any) -> EventStatus:
        taken = np.array(self._taken.Eval(context))
        new = taken > context.get_discrete_state(self._counted).value()
        heard = np.array(context.get_discrete_state(self._heard).value())
        heard = np.maximum(heard, np.where(new, self._stopped.Eval(context), 0.0))
        complete = new & (taken % self._loop == 0)
        detected = context.get_discrete_state(self._detected).value()
        discrete.set_value(self._detected, np.where(complete, heard, detected))
        discrete.set_value(self._heard, np.where(complete, 0.0, heard))
        discrete.set_value(self._counted, taken)
        return EventStatus.Succeeded()
