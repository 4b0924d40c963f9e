"""Settings of the PepperMill-Carrier's controllers and the arrays made of them."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import control
from ..c_drive_controllers import task_gain
from . import constants
from .control import COMPUTED_TORQUE, FEEDBACK, RESOLVED, Controller
from .parameters import PMCParameters

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class TaskSpacePD:
    """Task-space PD of the prototype; gains of Table 5-10, C-drives I and II.

    In the table drive I, the lower one, has twice the rotation gain of drive II against saturation by the unequal
    load of the counterweight.
    """

    kp_translation: tuple[float, float] = (35.0, 35.0)  # [N m/rad]
    kp_rotation: tuple[float, float] = (105.0, 52.5)  # [N m/rad]
    kd_translation: tuple[float, float] = (0.1, 0.1)  # [N m s/rad]
    kd_rotation: tuple[float, float] = (0.09, 0.09)  # [N m s/rad]
    cutoff: float = 600.0  # N [rad/s]


@dataclass(frozen=True, kw_only=True)
class JointPD:
    """PD on each motor (4.32); gains of Table 5-1."""

    kp: float = 45.0  # [N m/rad]
    kd: float = 0.1  # [N m s/rad]
    cutoff: float = 600.0  # N [rad/s]


@dataclass(frozen=True, kw_only=True)
class ComputedTorque:
    """Computed torque in joints; gains are our choice.

    Critically damped at 25 rad/s. One count of an encoder turns the PM by a degree, which the derivative passes on to
    the motors: faster poles or the prototype's filter of 600 rad/s make them saturate.
    """

    kp: float = 625.0  # [1/s^2]
    kd: float = 50.0  # [1/s]
    cutoff: float = 150.0  # N [rad/s]


@dataclass(frozen=True, kw_only=True)
class ResolvedAcceleration:
    """Resolved acceleration in the pose; gains are our choice.

    Critically damped at 30 rad/s in translation and, for the coarse rotation, at 20 rad/s.
    """

    kp_translation: float = 900.0  # [1/s^2]
    kp_rotation: float = 400.0  # [1/s^2]
    kd_translation: float = 60.0  # [1/s]
    kd_rotation: float = 40.0  # [1/s]
    cutoff: float = 150.0  # N [rad/s]


Settings = TaskSpacePD | JointPD | ComputedTorque | ResolvedAcceleration

# Names on the command line.
CONTROLLERS: dict[str, Settings] = {
    "ts": TaskSpacePD(),
    "pd": JointPD(),
    "ct": ComputedTorque(),
    "ra": ResolvedAcceleration(),
}


def controller(
    settings: Settings, model: PMCParameters, home: ArrayLike, sample_time: float
) -> Controller:
    """Arrays of a controller that believes in ``model``; motor angles are zero at joints ``home`` (4,)."""
    if not sample_time > 0.0:
        raise ValueError(f"sample_time is {sample_time}; expected a positive time in seconds")
    kind, kp, kd = _gains(settings, model.drive.lead)
    decay = float(control.derivative_decay(settings.cutoff, sample_time))
    return Controller(
        kind=kind,
        kp=kp,
        kd=kd,
        decay=decay,
        cutoff=settings.cutoff,
        rate_cutoff=(1.0 - decay) / sample_time,
        limit=model.torque_limit,
        joint_map=constants.joint_map(model.drive.lead),
        motor_map=constants.motor_map(model.drive.lead),
        home=np.array(home, dtype=float),
        model=constants.of(model),
    )


def _gains(settings: Settings, lead: float) -> tuple[int, Floats, Floats]:
    one = np.eye(4)
    if isinstance(settings, JointPD):
        return FEEDBACK, settings.kp * one, settings.kd * one
    if isinstance(settings, TaskSpacePD):
        s = settings
        return (
            FEEDBACK,
            _by_drive(s.kp_translation, s.kp_rotation, lead),
            _by_drive(s.kd_translation, s.kd_rotation, lead),
        )
    if isinstance(settings, ComputedTorque):
        return COMPUTED_TORQUE, settings.kp * one, settings.kd * one
    return (
        RESOLVED,
        np.diag([settings.kp_translation] * 3 + [settings.kp_rotation]),
        np.diag([settings.kd_translation] * 3 + [settings.kd_rotation]),
    )


def _by_drive(
    translation: tuple[float, float], rotation: tuple[float, float], lead: float
) -> Floats:
    gain = np.zeros((4, 4))
    for i in (0, 1):
        gain[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = task_gain(translation[i], rotation[i], lead)
    return gain
