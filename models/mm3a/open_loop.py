r"""Open-loop control of the MM3A: tip commands to joint steps by a step model, without any sensor.

1. differential: :math:`n_j = (J^{-1}\Delta x)_j / \gamma_j(q_0)`, sizes at the start only;
2. re-planned: after every step the believed joints advance by the model's step; a joint steps when it is
   further than half a step from where the inverse kinematics wants it;
3. velocity: :math:`r_j \leftarrow r_j + (J^{-1}\dot x)_j T`; a joint steps when :math:`|r_j|` exceeds half a step.

(1) is the conversion of chapter 7's reference 34, (2) follows a path however the step varies along it, (3)
is the teleoperation of chapter 8. All believe a step model and a posture: what they do not know - the true step
sizes - is the error they make. The inverse of J is closed-form; it does not exist on the axis of joint 1.
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import arm as arm_constants
from . import dynamics, kinematics, step_size, stepper
from .arm import Arm
from .step_size import STEP_TIME, StepModel
from .stepper import Conditions

# Nearest to the axis of joint 1 that a velocity command may come [m].
AXIS_CLEARANCE = 1e-3


def joint_rates(velocity: Any, q: Any, arm: Any) -> tuple[Any, Any, Any]:
    """Rates of joints at ``q`` that give the tip ``velocity`` [m/s] in frame 0, by the inverse of J.

    The arm's plane turns with joint 1; in it, joints 2 and 3 are polar coordinates about the elbow.
    """
    c1, s1, c2, s2 = np.cos(q[0]), np.sin(q[0]), np.cos(q[1]), np.sin(q[1])
    length = arm.forearm + q[2]
    reach = arm.shoulder - length * s2
    outward = c1 * velocity[0] + s1 * velocity[1]
    sideways = c1 * velocity[1] - s1 * velocity[0]
    return (
        sideways / reach,
        -(c2 * outward + s2 * velocity[2]) / length,
        c2 * velocity[2] - s2 * outward,
    )


def next_step(
    error: Any, joint: int, q: Any, last: Any, taken: Any, table: Any, session: Any, arm: Any
) -> int:
    """-1, 0 or 1: the step of ``joint`` that brings ``error`` [rad or m] below half a step (2, 3)."""
    direction = 1 if error > 0.0 else -1
    motion = stepper.coarse_motion(joint, direction, q, last, taken, table, session, arm)
    return direction if 2.0 * np.abs(error) > motion * direction > 0.0 else 0


def differential_steps(
    move: Any,
    start: Any,
    *,
    model: StepModel | None = None,
    arm: Arm | None = None,
    conditions: Conditions | None = None,
) -> NDArray[np.int64]:
    """Signed steps (1) of the three joints for a tip displacement ``move`` (3,) [m] in frame 0."""
    arm, session = arm or Arm(), (conditions or Conditions()).session()
    table = (model or StepModel()).table()
    angles = joint_rates(move, start, arm)
    loads = step_size.load_factors(start, session.gravity, session.force, arm)
    travel = arm.upper_3 - arm.lower_3
    steps = [
        distance
        / step_size.step_size(joint, int(distance > 0.0), start, loads[joint], table, travel)
        for joint, distance in enumerate(angles)
    ]
    return np.rint(steps).astype(np.int64)


def interleave(steps: Any) -> NDArray[np.int64]:
    """Commands per tick (n, 3) that spread the signed ``steps`` (3,) evenly over the longest of them."""
    steps = np.asarray(steps)
    ticks = int(np.abs(steps).max())
    share = np.arange(ticks + 1)[:, None] * np.abs(steps) / max(ticks, 1)
    return np.diff(np.rint(share).astype(np.int64), axis=0) * np.sign(steps)


def straight_path(start: Any, end: Any, speed: float) -> NDArray[np.float64]:
    """Tip positions per tick (n, 3) from ``start`` to ``end`` [m] in frame 0 at ``speed`` [m/s]."""
    if not speed > 0.0:
        raise ValueError(f"path: speed is {speed} m/s; expected a positive number")
    start, end = np.asarray(start, dtype=float), np.asarray(end, dtype=float)
    ticks = max(1, int(np.ceil(np.linalg.norm(end - start) / (speed * STEP_TIME))))
    return start + (end - start) * np.arange(1, ticks + 1)[:, None] / ticks


def follow(
    path: NDArray[np.float64],
    start: Any,
    *,
    model: StepModel | None = None,
    arm: Arm | None = None,
    conditions: Conditions | None = None,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Re-planned commands (2) per tick for tip positions ``path`` (n, 3), and the believed joints (n + 1, 3).

    ``start`` is the believed posture; the branch of the inverse kinematics is the one it is on. Raises
    ValueError where the path leaves the workspace, naming the first such point.
    """
    from . import stepper_kernel

    arm, conditions = arm or Arm(), conditions or Conditions()
    wanted = _wanted(np.ascontiguousarray(path, dtype=float), start, arm)
    commands = np.zeros(wanted.shape, dtype=np.int64)
    believed = np.empty((len(wanted) + 1, 3))
    believed[0] = start
    stepper_kernel.follow(
        wanted,
        commands,
        believed,
        (model or StepModel()).table(),
        conditions.session(),
        arm.constants(),
        np.array(arm.lower),
        np.array(arm.upper),
    )
    return commands, believed


def _wanted(path: NDArray[np.float64], start: Any, arm: Arm) -> NDArray[np.float64]:
    """Joints for every point of the path, on the branch of ``start``."""
    from . import stepper_kernel

    backward = bool(arm.shoulder < (arm.forearm + start[2]) * np.sin(start[1]))
    wanted = stepper_kernel.inverse(path, arm.constants(), backward)
    outside = np.any((wanted < arm.lower) | (wanted > arm.upper), axis=1)
    if np.any(outside):
        i = int(np.argmax(outside))
        raise ValueError(
            f"path: point {i} at {tuple(map(float, path[i]))} m needs joints "
            f"{tuple(map(float, wanted[i]))}; expected them within {arm.lower} to {arm.upper}"
        )
    return wanted


LAW_MODULES = (arm_constants, kinematics, dynamics, step_size, stepper)
