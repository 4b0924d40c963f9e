r"""What happens at one commanded step, and the compiled loop over many of them.

A coarse step of joint j in direction s moves it by

1. :math:`s\,\gamma_{js}(q)\,\kappa_{js}\,(1 + h_j (1 - e^{-n/n_h}))\,(1 - r_j)`, then the end stop

with the step size :math:`\gamma` of ``step_size.py``, a factor :math:`\kappa` of the day (sections 4.2, 5.2),
warming after n steps (reference 51 of the thesis) and, on the first step after a reversal only, a loss r.
The thesis quantifies neither warming nor reversal: both are off unless set. Joints step one after
the other (chapter 3) and do not disturb each other (chapter 8). Fine mode moves the piezo without
slip inside its stroke, and adds to the position.
"""

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from . import kinematics, step_size
from .arm import Arm, gravity_in_base
from .step_size import StepModel


class Session(NamedTuple):
    """Conditions of one session in the form kernels take; build it with ``session``."""

    gravity: tuple[float, float, float]  # in frame 0 [m/s^2]
    force: tuple[float, float, float]  # on the tip, in frame 0 [N]
    scale: Any  # (3, 2) factor of the day by joint and direction [-]
    heating: Any  # (3,) step growth from cold to warm [-]
    heating_steps: Any  # (3,) steps to 63 % of it [-]
    reversal_loss: Any  # (3,) share of the first step after a reversal that is lost [-]


@dataclass(frozen=True, kw_only=True)
class Conditions:
    """Base tilt, tip force and drift of one session.

    Raises ValueError if a drift constant is out of its range or an array has the wrong shape.
    """

    theta: float = 0.0  # base tilt about x [rad]
    psi: float = 0.0  # base tilt about the new y [rad]
    force: tuple[float, float, float] = (0.0, 0.0, 0.0)  # on the tip, in frame 0 [N]
    scale: tuple[tuple[float, float], ...] = ((1.0, 1.0),) * 3  # by joint, (negative, positive) [-]
    heating: tuple[float, float, float] = (0.0, 0.0, 0.0)  # growth from cold to warm [-]
    heating_steps: float = 20_000.0  # steps to 63 % of the growth [-]
    reversal_loss: tuple[float, float, float] = (0.0, 0.0, 0.0)  # of the first step back [-]

    def __post_init__(self) -> None:
        if np.shape(self.scale) != (3, 2) or not np.min(self.scale) > 0.0:
            raise ValueError(
                f"conditions: scale is {self.scale}; expected three positive pairs, one per joint"
            )
        if not self.heating_steps > 0.0:
            raise ValueError(
                f"conditions: heating_steps is {self.heating_steps}; expected a positive number"
            )
        if not (min(self.reversal_loss) >= 0.0 and max(self.reversal_loss) <= 1.0):
            raise ValueError(
                f"conditions: reversal_loss is {self.reversal_loss}; expected shares in [0, 1]"
            )

    def session(self) -> Session:
        """Return the arrays kernels take."""
        return Session(
            gravity=gravity_in_base(float(self.theta), float(self.psi)),
            force=(float(self.force[0]), float(self.force[1]), float(self.force[2])),
            scale=np.array(self.scale, dtype=float),
            heating=np.array(self.heating, dtype=float),
            heating_steps=np.full(3, float(self.heating_steps)),
            reversal_loss=np.array(self.reversal_loss, dtype=float),
        )


def coarse_motion(
    joint: int,
    direction: int,
    q: Any,
    last: Any,
    taken: Any,
    table: Any,
    session: Any,
    arm: Any,
) -> Any:
    """Signed motion (1) of ``joint`` [rad or m] for one step, before the end stop.

    ``direction`` is -1 or 1, ``last`` (3,) the direction of each joint's step before (0 for none) and
    ``taken`` (3,) the steps each joint has made in this session.
    """
    side = step_size.POSITIVE if direction > 0 else step_size.NEGATIVE
    load = step_size.load_factors(q, session.gravity, session.force, arm)[joint]
    size = step_size.step_size(joint, side, q, load, table, arm.upper_3 - arm.lower_3)
    size = size * session.scale[joint, side]
    warmth = 1.0 - np.exp(-taken[joint] / session.heating_steps[joint])
    size = size * (1.0 + session.heating[joint] * warmth)
    if last[joint] * direction < 0:
        size = size * (1.0 - session.reversal_loss[joint])
    return direction * size


def coarse_step(
    joint: int,
    direction: int,
    q: Any,
    last: Any,
    taken: Any,
    table: Any,
    session: Any,
    arm: Any,
    lower: Any,
    upper: Any,
) -> bool:
    """Take one step: update ``q``, ``last`` and ``taken`` in place; True if the joint hit its stop."""
    motion = coarse_motion(joint, direction, q, last, taken, table, session, arm)
    target = q[joint] + motion
    q[joint] = min(max(target, lower[joint]), upper[joint])
    last[joint] = direction
    taken[joint] += 1
    return target < lower[joint] or target > upper[joint]


def fine_extension(extension: Any, steps: int, joint: int) -> Any:
    """Piezo extension [rad or m] after ``steps`` fine steps, held inside half the stroke each way."""
    half = 0.5 * step_size.STROKE[joint]
    return min(max(extension + steps * step_size.FINE_STEP[joint], -half), half)


@dataclass(frozen=True, kw_only=True)
class Travel:
    """Outcome of a run of the stepper."""

    positions: NDArray[np.float64]  # (n + 1, 3) joints before the first and after every tick
    taken: NDArray[np.int64]  # (3,) steps each joint has made
    stopped: NDArray[np.bool_]  # (n, 3) a joint was driven against its end stop


def run(
    commands: NDArray[np.integer[Any]],
    start: Any,
    *,
    model: StepModel | None = None,
    arm: Arm | None = None,
    conditions: Conditions | None = None,
) -> Travel:
    """Play ``commands`` (n, 3) of -1, 0, 1 per tick of 10 ms from joints ``start``, compiled.

    Raises ValueError for other commands or a start outside the joint limits.
    """
    from . import stepper_kernel

    arm, conditions = arm or Arm(), conditions or Conditions()
    ticks = np.ascontiguousarray(commands, dtype=np.int64)
    if ticks.ndim != 2 or ticks.shape[1] != 3 or np.any(np.abs(ticks) > 1):
        raise ValueError(
            f"commands have shape {np.shape(commands)}; expected (n, 3) with elements -1, 0 or 1, "
            "one row per 10 ms"
        )
    if not kinematics.within_limits(start, arm):
        raise ValueError(f"start {start} is outside the limits {arm.lower} to {arm.upper}")
    positions = np.empty((len(ticks) + 1, 3))
    positions[0] = start
    taken = np.zeros(3, dtype=np.int64)
    stopped = np.zeros(ticks.shape, dtype=np.bool_)
    stepper_kernel.play(
        ticks,
        positions,
        taken,
        stopped,
        (model or StepModel()).table(),
        conditions.session(),
        arm.constants(),
        np.array(arm.lower),
        np.array(arm.upper),
    )
    return Travel(positions=positions, taken=taken, stopped=stopped)


def steps_between(
    joint: int,
    start: Any,
    target: float,
    *,
    model: StepModel | None = None,
    arm: Arm | None = None,
    conditions: Conditions | None = None,
) -> int:
    """Steps that bring ``joint`` (0, 1, 2) from joints ``start`` to ``target``, or past it [rad or m].

    Raises ValueError if a step has no length on the way, which is a load beyond the model.
    """
    from . import stepper_kernel

    arm, conditions = arm or Arm(), conditions or Conditions()
    session = conditions.session()
    count = stepper_kernel.count(
        joint,
        np.array(start, dtype=float),
        float(target),
        (model or StepModel()).table(),
        session,
        arm.constants(),
    )
    if count < 0:
        raise ValueError(
            f"joint {joint + 1} stops making way between {start[joint]} and {target}; expected steps "
            "of positive length: the load is beyond the step model"
        )
    return int(count)
