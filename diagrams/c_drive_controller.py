"""The C-drive's controllers as Diagrams of the blocks in Figs. 4-1 and 4-2."""

from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, System

from ..models.c_drive import CDriveParameters, damping_matrix, inertia_matrix
from ..models.c_drive_controllers import PD, ComputedTorque, TaskSpacePD
from ..models.observer import minimum_order_observer
from ..systems import computed_torque, pd, pid, resolved_acceleration, task_space_pd
from ..systems.filtered_derivative import FilteredDerivative
from ..systems.rate_observer import RateObserver
from ..systems.tracking_error import TrackingError
from ..systems.unit_delay import UnitDelay

Settings = PD | TaskSpacePD | ComputedTorque


def c_drive_controller(settings: Settings, model: CDriveParameters, dt: float) -> Diagram:
    """A controller of the C-drive, sampled every ``dt`` seconds.

    | port | size | unit |
    |---|---|---|
    | in  `reference`    | 2 | rad, motors (L, R) |
    | in  `position`     | 2 | rad |
    | in  `acceleration` | 2 | rad/s^2, of the reference; model-based controllers only |
    | out `torque`       | 2 | N m |

    ``model`` is the drive as the controller believes it to be. Subsystems: ``error``, ``derivative``,
    ``law`` and, for model-based controllers, ``observer`` and ``unit_delay`` as in Fig. 4-2.
    Raises ValueError as the models do for a gain, pole or time that cannot be used.
    """
    builder = DiagramBuilder()
    error = _add(builder, "error", TrackingError(2))
    derivative = _add(builder, "derivative", FilteredDerivative(2, settings.cutoff, dt))
    law = _add(builder, "law", _law(settings, model, dt))
    builder.Connect(error.GetOutputPort("error"), derivative.GetInputPort("signal"))
    builder.Connect(error.GetOutputPort("error"), law.GetInputPort("error"))
    builder.Connect(derivative.GetOutputPort("derivative"), law.GetInputPort("error_rate"))
    builder.ExportInput(error.GetInputPort("reference"), "reference")
    position = builder.ExportInput(error.GetInputPort("position"), "position")
    builder.ExportOutput(law.GetOutputPort("torque"), "torque")
    if isinstance(settings, ComputedTorque):
        observer = _add(
            builder,
            "observer",
            RateObserver(minimum_order_observer(model, settings.poles, dt), dt),
        )
        delay = _add(builder, "unit_delay", UnitDelay(2, dt))
        builder.ConnectInput(position, observer.GetInputPort("position"))
        builder.Connect(law.GetOutputPort("torque"), delay.GetInputPort("signal"))
        builder.Connect(delay.GetOutputPort("delayed"), observer.GetInputPort("torque"))
        builder.Connect(observer.GetOutputPort("rate"), law.GetInputPort("rate"))
        builder.ExportInput(law.GetInputPort("acceleration"), "acceleration")
    return builder.Build()


def _law(settings: Settings, model: CDriveParameters, dt: float) -> System:
    s = settings
    if isinstance(s, PD):
        if s.ki == 0.0:
            return pd.PD(2, kp=s.kp, kd=s.kd)
        return pid.PID(2, kp=s.kp, ki=s.ki, kd=s.kd, period=dt)
    if isinstance(s, TaskSpacePD):
        return task_space_pd.TaskSpacePD(
            kp=(s.kp_translation, s.kp_rotation),
            kd=(s.kd_translation, s.kd_rotation),
            lead=model.lead,
        )
    inertia = inertia_matrix(model)
    damping = s.friction_compensation * damping_matrix(model)
    if s.kp_rotation is None and s.kd_rotation is None:
        return computed_torque.ComputedTorque(kp=s.kp, kd=s.kd, inertia=inertia, damping=damping)
    return resolved_acceleration.ResolvedAcceleration(
        kp=(s.kp, s.kp if s.kp_rotation is None else s.kp_rotation),
        kd=(s.kd, s.kd if s.kd_rotation is None else s.kd_rotation),
        inertia=np.asarray(inertia),
        damping=np.asarray(damping),
        lead=model.lead,
    )


def _add(builder: DiagramBuilder, name: str, system: System) -> Any:
    system.set_name(name)
    return builder.AddSystem(system)
