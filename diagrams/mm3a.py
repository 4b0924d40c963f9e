"""The MM3A moved by a hand: velocity command, steps, joints, tip."""

from typing import Any

from pydrake.systems.framework import Diagram, DiagramBuilder

from ..models.mm3a.step_size import StepModel
from ..models.mm3a.stepper import Conditions
from ..systems.mm3a.kinematics import TipPosition
from ..systems.mm3a.stepper import Stepper
from ..systems.mm3a.teleoperation import VelocityToSteps


def teleoperation(
    stepper: Stepper,
    start: Any,
    *,
    model: StepModel | None = None,
    conditions: Conditions | None = None,
) -> Diagram:
    """Diagram with input ``velocity`` [m/s] and outputs ``joints``, ``tip``, ``believed``, ``commands``.

    ``stepper`` is what really moves, empirical or physical; ``model`` and ``conditions`` are what the
    conversion believes of it, from the posture ``start``.
    """
    builder = DiagramBuilder()
    hand = builder.AddSystem(
        VelocityToSteps(start, model=model, arm=stepper.arm, conditions=conditions)
    )
    builder.AddSystem(stepper)
    tip = builder.AddSystem(TipPosition(stepper.arm))
    builder.Connect(hand.GetOutputPort("commands"), stepper.GetInputPort("commands"))
    builder.Connect(stepper.GetOutputPort("joints"), tip.GetInputPort("joints"))
    builder.ExportInput(hand.GetInputPort("velocity"), "velocity")
    builder.ExportOutput(stepper.GetOutputPort("joints"), "joints")
    builder.ExportOutput(tip.GetOutputPort("tip"), "tip")
    builder.ExportOutput(hand.GetOutputPort("believed"), "believed")
    builder.ExportOutput(hand.GetOutputPort("commands"), "commands")
    return builder.Build()
