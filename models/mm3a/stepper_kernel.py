"""Compiled loops of ``stepper.py``."""

from typing import Any

import numpy as np

from .. import compilation
from . import kinematics, open_loop, stepper

compilation.register_laws(*open_loop.LAW_MODULES, open_loop)


@compilation.kernel
def play(
    ticks: Any,
    positions: Any,
    taken: Any,
    stopped: Any,
    table: Any,
    session: Any,
    arm: Any,
    lower: Any,
    upper: Any,
) -> None:
    """Fill ``positions`` after each row of ``ticks``, from ``positions[0]``."""
    q = positions[0].copy()
    last = np.zeros(3, dtype=np.int64)
    for i in range(ticks.shape[0]):
        for joint in range(3):
            direction = ticks[i, joint]
            if direction != 0:
                stopped[i, joint] = stepper.coarse_step(
                    joint, direction, q, last, taken, table, session, arm, lower, upper
                )
        positions[i + 1, 0] = q[0]
        positions[i + 1, 1] = q[1]
        positions[i + 1, 2] = q[2]


@compilation.kernel
def count(joint: int, q: Any, target: float, table: Any, session: Any, arm: Any) -> int:
    """Steps until ``target`` is reached or passed; -1 if a step does not lead towards it."""
    direction = 1 if target > q[joint] else -1
    last = np.zeros(3, dtype=np.int64)
    taken = np.zeros(3, dtype=np.int64)
    while (target - q[joint]) * direction > 0.0:
        motion = stepper.coarse_motion(joint, direction, q, last, taken, table, session, arm)
        if motion * direction <= 0.0:
            return -1
        q[joint] += motion
        taken[joint] += 1
        last[joint] = direction
    return taken[joint]


@compilation.kernel
def follow(
    wanted: Any,
    commands: Any,
    believed: Any,
    table: Any,
    session: Any,
    arm: Any,
    lower: Any,
    upper: Any,
) -> None:
    """Fill ``commands`` and ``believed`` joints so that these stay within half a step of ``wanted``."""
    q = believed[0].copy()
    last = np.zeros(3, dtype=np.int64)
    taken = np.zeros(3, dtype=np.int64)
    for i in range(wanted.shape[0]):
        for joint in range(3):
            error = wanted[i, joint] - q[joint]
            step = open_loop.next_step(error, joint, q, last, taken, table, session, arm)
            commands[i, joint] = step
            if step != 0:
                stepper.coarse_step(joint, step, q, last, taken, table, session, arm, lower, upper)
        believed[i + 1, 0] = q[0]
        believed[i + 1, 1] = q[1]
        believed[i + 1, 2] = q[2]


@compilation.kernel
def inverse(path: Any, arm: Any, backward: bool) -> Any:
    """Joints (n, 3) that bring the tip to each point of ``path`` (n, 3)."""
    joints = np.empty(path.shape)
    for i in range(path.shape[0]):
        q1, q2, q3 = kinematics.inverse(path[i], arm, backward)
        joints[i, 0] = q1
        joints[i, 1] = q2
        joints[i, 2] = q3
    return joints
