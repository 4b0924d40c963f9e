"""Controllers of the C-drive benchmark as arrays for the kernels (Friedlaender 2015, Table 5-1)."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .c_drive import CDriveParameters, damping_matrix, inertia_matrix, inverse_jacobian, jacobian
from .drive_kernels import FEEDBACK, LoopController
from .observer import DiscreteObserver, minimum_order_observer


@dataclass(frozen=True, kw_only=True)
class PD:
    """Joint-space PD (4.32 without the integral); gains of Table 5-1."""

    kp: float = 45.0  # [N m/rad]
    kd: float = 0.1  # [N m s/rad]
    ki: float = 0.0  # [N m/(rad s)], the ideal PID of 4.6.1
    cutoff: float = 600.0  # N [rad/s]


@dataclass(frozen=True, kw_only=True)
class TaskSpacePD:
    """Task-space PD (4.37) with gains for the collar's translation and rotation; Table 5-1."""

    kp_translation: float = 45.0  # [N m/rad]
    kp_rotation: float = 112.5  # [N m/rad]
    kd_translation: float = 0.1  # [N m s/rad]
    kd_rotation: float = 0.25  # [N m s/rad]
    cutoff: float = 600.0  # N [rad/s]


@dataclass(frozen=True, kw_only=True)
class ComputedTorque:
    """Computed torque with observer (4.33-4.35); gains of Table 5-1.

    With rotation gains of their own this is the resolved-acceleration controller of section 4.6.4.
    """

    kp: float = 35000.0  # [1/s^2], of translation where rotation has its own
    kd: float = 55.0  # [1/s]
    kp_rotation: float | None = None  # [1/s^2]
    kd_rotation: float | None = None  # [1/s]
    cutoff: float = 600.0  # N [rad/s]
    poles: tuple[complex, complex] = (-600.0, -600.0)  # of the observer [rad/s]
    friction_compensation: float = 0.4  # c [-]


def task_gain(translation: float, rotation: float, lead: float) -> NDArray[np.float64]:
    """J^-1 diag(translation, rotation) J of eq. (4.37a): a task-space gain in motor coordinates."""
    return np.asarray(inverse_jacobian(lead) @ np.diag([translation, rotation]) @ jacobian(lead))


def loop_controller(
    settings: PD | TaskSpacePD | ComputedTorque, model: CDriveParameters, dt: float
) -> LoopController:
    """The controller for the kernels; ``model`` is the drive as the controller believes it to be.

    ``dt`` [s] is the sample time at which the observer is discretised.
    """
    one, zero = np.eye(2), np.zeros((2, 2))
    if isinstance(settings, PD):
        return feedback(
            kp=settings.kp * one,
            ki=settings.ki * one,
            kd=settings.kd * one,
            cutoff=settings.cutoff,
            output=one,
        )
    if isinstance(settings, TaskSpacePD):
        return feedback(
            kp=task_gain(settings.kp_translation, settings.kp_rotation, model.lead),
            ki=zero,
            kd=task_gain(settings.kd_translation, settings.kd_rotation, model.lead),
            cutoff=settings.cutoff,
            output=one,
        )
    kp_rotation = settings.kp if settings.kp_rotation is None else settings.kp_rotation
    kd_rotation = settings.kd if settings.kd_rotation is None else settings.kd_rotation
    return feedback(
        kp=task_gain(settings.kp, kp_rotation, model.lead),
        ki=zero,
        kd=task_gain(settings.kd, kd_rotation, model.lead),
        cutoff=settings.cutoff,
        output=inertia_matrix(model),
        feedforward=1.0,
        friction=settings.friction_compensation * damping_matrix(model),
        observer=minimum_order_observer(model, settings.poles, dt),
    )


def feedback(
    *,
    kp: Any,
    ki: Any,
    kd: Any,
    cutoff: float,
    output: Any,
    feedforward: float = 0.0,
    friction: Any = None,
    observer: DiscreteObserver | None = None,
) -> LoopController:
    """FEEDBACK with these matrices (n, n); without an observer it knows no rate."""
    zero = np.zeros_like(kp)
    observer = observer or DiscreteObserver(zero, zero, zero, zero, zero)
    return LoopController(
        kind=FEEDBACK,
        kp=kp,
        ki=ki,
        kd=kd,
        cutoff=cutoff,
        output=output,
        feedforward=feedforward,
        friction=zero if friction is None else friction,
        **observer._asdict(),
        kv=0.0,
        limit=np.inf,
    )
