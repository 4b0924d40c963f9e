"""What an unsigned servo torque says beside the angles: at rest it is the error times the stiffness.

A proportional servo that stands still holds its load by the error it sees. If the logged error grows with
the logged torque, the servo sees what is logged; an error without torque is one that the servo does not
see: a false zero, or a clearance behind its encoder.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from scipy.stats import spearmanr

from ..machine import Array

if TYPE_CHECKING:
    from .serial_arm import ArmRun

AT_REST = 50  # samples over which no joint's reference has moved
SEES = 0.5  # rank correlation from which on the servo sees the logged error
FEWEST = 200  # samples at rest
ALIKE = 0.1  # spread of the errors, of their median, below which their ranks are those of noise


def at_rest(run: "ArmRun") -> Array:
    """Which samples (fine,) come after ``AT_REST`` samples without a change of any reference."""
    moved = np.any(np.diff(run.fine_reference, axis=1) != 0.0, axis=0)
    count = np.concatenate([[0], np.cumsum(moved)])
    still = np.zeros(count.size, dtype=bool)
    still[AT_REST:] = count[AT_REST:] == count[:-AT_REST]
    return still


def errors_and_torques(runs: "Sequence[ArmRun]") -> tuple[Array, Array]:
    """Measured less asked angles [rad] and torque magnitudes [N m] at rest, both (samples, joints)."""
    errors, torques = [], []
    for run in runs:
        if run.torque is not None:
            rest = at_rest(run)
            errors.append((run.fine_position - run.fine_reference).T[rest])
            torques.append(run.torque[rest])
    if not errors:
        return np.zeros((0, 0)), np.zeros((0, 0))
    return np.concatenate(errors), np.concatenate(torques)


def agreement(runs: "Sequence[ArmRun]") -> float | None:
    """Rank correlation at rest of torque and size of the error, all joints together; None if unknown.

    Joints of equal dry friction all stop at the same error: between errors (quartiles) closer than ``ALIKE`` of their
    median the ranks are those of noise, and nothing is known.
    """
    errors, torques = errors_and_torques(runs)
    sizes = np.abs(errors)
    if len(errors) < FEWEST or np.ptp(torques) == 0.0 or np.ptp(sizes) == 0.0:
        return None
    low, middle, high = np.percentile(sizes, [25.0, 50.0, 75.0])
    if high - low < ALIKE * middle:
        return None
    return float(spearmanr(sizes.ravel(), torques.ravel()).statistic)


def loop_acts_on_log(runs: "Sequence[ArmRun]") -> bool:
    """Whether the torque at rest follows the logged error."""
    found = agreement(runs)
    return found is not None and found > SEES


def torque_remarks(joints: Sequence[str], runs: "Sequence[ArmRun]") -> list[str]:
    """What the torque says, in words; nothing where it is not logged or the arm never rests."""
    found = agreement(runs)
    if found is None:
        return []
    errors, torques = errors_and_torques(runs)
    by_joint = ", ".join(
        f"{joint} {np.mean(t):.3f} N m at {np.mean(e):+.4f} rad"
        for joint, t, e in zip(joints, torques.T, errors.T)
    )
    if found > SEES:
        follows = "the servos act on what is logged: no false zero, scale or clearance behind them is tried"
    else:
        follows = "what is logged need not be what the servos act on"
    return [
        f"Mean torque and error at rest, which no fit uses: {by_joint}. Their rank correlation is "
        f"{found:.2f}: {follows}."
    ]
