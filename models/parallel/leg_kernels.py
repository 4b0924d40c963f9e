"""Compiled loops over the postures of tables on three P-R-S legs; the laws are those of ``legs``."""

from typing import Any

import numpy as np

from .. import compilation
from . import legs as laws
from .legs import Legs

compilation.register_laws(laws)

NEWTON_STEPS = 30
FAR = 10.0  # [m or rad], where Newton has gone astray


@compilation.kernel
def pose_all(task: Any, legs: Legs, position: Any, turned: Any, phi: Any, joints: Any) -> None:
    """Poses at tasks (batch, 3): position (batch, 3), R (batch, 3, 3), phi (batch,), joints (batch, 3, 3)."""
    for s in range(task.shape[0]):
        phi[s] = laws.pose(task[s], legs, position[s], turned[s], joints[s])


@compilation.kernel
def inverse_all(task: Any, legs: Legs, modes: Any, out: Any) -> None:
    """Slider positions (batch, 3) at tasks (batch, 3)."""
    position, turned, joints = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    for s in range(task.shape[0]):
        laws.pose(task[s], legs, position, turned, joints)
        laws.sliders(joints, legs, modes, out[s])


@compilation.kernel
def bars_all(joints: Any, q: Any, legs: Legs, out: Any) -> None:
    """Vectors (batch, 3, 3) from sliders (batch, 3) to joints (batch, 3, 3)."""
    for s in range(q.shape[0]):
        laws.bars(joints[s], q[s], legs, out[s])


@compilation.kernel
def twist_all(
    position: Any, joints: Any, q: Any, legs: Legs, jacobian: Any, constraint: Any
) -> None:
    """Twists (batch, 6, 3) per slider rate and left-hand matrices (batch, 6, 6) of (3) at given poses."""
    rods, left = np.empty((3, 3)), np.empty((6, 6))
    for s in range(q.shape[0]):
        laws.bars(joints[s], q[s], legs, rods)
        laws.constraints(position[s], joints[s], rods, legs, left, jacobian[s])
        constraint[s] = left
        laws.solve(left, jacobian[s])


@compilation.kernel
def jacobian_all(task: Any, q: Any, legs: Legs, out: Any) -> None:
    """Rates of the tasks per slider rate (batch, 3, 3) at tasks and sliders (batch, 3)."""
    for s in range(task.shape[0]):
        _task_jacobian(task[s], q[s], legs, out[s])


@compilation.part
def _task_jacobian(task: Any, q: Any, legs: Legs, out: Any) -> None:
    position, turned, joints = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    rods, left, twist = np.empty((3, 3)), np.empty((6, 6)), np.empty((6, 3))
    phi = laws.pose(task, legs, position, turned, joints)
    laws.bars(joints, q, legs, rods)
    laws.constraints(position, joints, rods, legs, left, twist)
    laws.solve(left, twist)
    laws.task_rates(turned, twist, task[1], phi, np.empty((3, 3)), out)


@compilation.kernel
def forward_all(q: Any, legs: Legs, tolerance: float, task: Any) -> None:
    """Newton from ``task`` (batch, 3) to the tasks at slider positions (batch, 3); NaN where it does not converge."""
    ahead = np.array([-1.0, -1.0, -1.0])
    position, turned, joints = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    there, error, jacobian = np.empty(3), np.empty(3), np.empty((3, 3))
    for s in range(q.shape[0]):
        x = task[s]
        off = np.nan
        for step in range(NEWTON_STEPS + 1):
            laws.pose(x, legs, position, turned, joints)
            laws.sliders(joints, legs, ahead, there)
            off = 0.0
            for i in range(3):
                error[i] = q[s, i] - there[i]
                off = max(off, np.abs(error[i]))
            if not np.abs(error[0] + error[1] + error[2]) < np.inf:
                off = np.nan
            if not off > tolerance or step == NEWTON_STEPS:
                break
            _task_jacobian(x, there, legs, jacobian)
            for i in range(3):
                x[i] += laws.dot(jacobian[i], error)
            if max(np.abs(x[0]), np.abs(x[1]), np.abs(x[2])) > FAR:
                break
        if not off <= max(tolerance, 1e-12):
            x[:] = np.nan


@compilation.kernel
def motion_all(task: Any, v: Any, legs: Legs, jacobian: Any, drift: Any, spins: Any) -> None:
    """Motion of the seven bodies at tasks and slider rates (batch, 3), into arrays of zeros.

    Jacobians (batch, 7, 6, 3), drifts (batch, 7, 6), spins (batch, 7, 3) in the order of ``prs.BODIES``.
    """
    for s in range(task.shape[0]):
        _motion(task[s], v[s], legs, jacobian[s], drift[s], spins[s])


@compilation.part
def _motion(task: Any, v: Any, legs: Legs, jacobian: Any, drift: Any, spins: Any) -> None:
    position, turned, joints = np.empty(3), np.empty((3, 3)), np.empty((3, 3))
    q, rods = np.empty(3), np.empty((3, 3))
    left, again, twist = np.empty((6, 6)), np.empty((6, 6)), np.empty((6, 3))
    normal, arms, inward = np.empty((3, 3)), np.empty((3, 3)), np.empty((3, 3))
    rows, turn, bias = np.empty((3, 3)), np.empty(3), np.empty((6, 1))
    laws.pose(task, legs, position, turned, joints)
    laws.sliders(joints, legs, np.array([-1.0, -1.0, -1.0]), q)
    laws.bars(joints, q, legs, rods)
    laws.constraints(position, joints, rods, legs, left, twist)
    again[:] = left
    laws.solve(left, twist)
    spin = (laws.dot(twist[3], v), laws.dot(twist[4], v), laws.dot(twist[5], v))
    square = legs.bar * legs.bar
    for k in range(3):
        normal[k, 0], normal[k, 1], normal[k, 2] = laws.cross(legs.across[k], rods[k])
        for i in range(3):
            arms[k, i] = joints[k, i] - position[i]
        inward[k, 0], inward[k, 1], inward[k, 2] = laws.cross(spin, laws.cross(spin, arms[k]))
        for c in range(3):
            rate = laws.point_rate(twist, c, arms[k])
            slide = laws.dot(normal[k], legs.along[k]) if c == k else 0.0
            rows[k, c] = (laws.dot(normal[k], rate) - slide) / square
        turn[k] = laws.dot(rows[k], v)
        bias[k, 0] = -laws.dot(rods[k], inward[k]) / legs.bar - turn[k] * turn[k] * legs.bar
        bias[3 + k, 0] = -laws.dot(legs.across[k], inward[k])
    laws.solve(again, bias)
    for k in range(3):
        lifted = laws.point_rate(bias, 0, arms[k])
        turn_bias = (laws.dot(normal[k], lifted) + laws.dot(normal[k], inward[k])) / square
        laws.bar_motion(
            k, rods, normal[k], rows[k], turn[k], turn_bias, legs, jacobian[k], drift[k]
        )
        spins[k, 0] = turn[k]
        for i in range(3):
            jacobian[4 + k, i, k] = legs.along[k, i]
    laws.platform_motion(turned, twist, bias, spin, legs, jacobian[3], drift[3], spins[3])
