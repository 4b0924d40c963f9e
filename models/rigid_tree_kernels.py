"""Compiled loops of ``rigid_tree`` and ``joint``: regressor, equation columns, residual, loop."""

from typing import Any

import numpy as np

from . import compilation, friction, joint, rigid_tree
from .joint import DELAY, GAIN, LAG, LIMIT
from .rigid_tree import FIXED, PRISMATIC, REVOLUTE

compilation.register_laws(friction, joint, rigid_tree)


@compilation.kernel
def regressor(tree: Any, q: Any, v: Any, a: Any, gravity: Any, out: Any) -> None:
    """Efforts (n, 10 B) per standard inertial parameter at one state; ``gravity`` (3,) in the world."""
    bodies = tree.parent.size
    R, p = np.zeros((bodies, 3, 3)), np.zeros((bodies, 3))
    w, dw, acc = np.zeros((bodies, 3)), np.zeros((bodies, 3)), np.zeros((bodies, 3))
    axis_W, anchor = np.zeros((bodies, 3)), np.zeros((bodies, 3))
    turn, R_F, R_M, world = np.zeros((3, 3)), np.zeros((3, 3)), np.zeros((3, 3)), np.eye(3)
    force, moment = np.zeros((10, 3)), np.zeros((10, 3))
    still, fall = np.zeros(3), -gravity
    out[:] = 0.0
    for i in range(bodies):
        up = tree.parent[i]
        R_P, p_P = (R[up], p[up]) if up >= 0 else (world, still)
        w_P, dw_P, a_P = (w[up], dw[up], acc[up]) if up >= 0 else (still, still, fall)
        rigid_tree.product(R_P, tree.R_PF[i], R_F)
        on_parent = rigid_tree.times(R_P, tree.p_PF[i])
        axis = rigid_tree.times(R_F, tree.axis[i])
        k = tree.column[i]
        kind = tree.joint[i]
        rigid_tree.rotation(tree.axis[i], q[k] if kind == REVOLUTE else 0.0, turn)
        rigid_tree.product(R_F, turn, R_M)
        rigid_tree.product(R_M, tree.R_MB[i], R[i])
        on_joint = rigid_tree.times(R_M, tree.p_MB[i])
        across = rigid_tree.cross(w_P, axis)
        turns = 1.0 if kind == REVOLUTE else 0.0
        slides = 1.0 if kind == PRISMATIC else 0.0
        to_joint = (0.0, 0.0, 0.0)
        if kind == PRISMATIC:
            to_joint = (axis[0] * q[k], axis[1] * q[k], axis[2] * q[k])
        rate, gain = (v[k], a[k]) if kind != FIXED else (0.0, 0.0)
        for j in range(3):
            anchor[i, j] = p_P[j] + on_parent[j]
            axis_W[i, j] = axis[j]
            p[i, j] = anchor[i, j] + to_joint[j] + on_joint[j]
            w[i, j] = w_P[j] + turns * axis[j] * rate
            dw[i, j] = dw_P[j] + turns * (axis[j] * gain + across[j] * rate)
        lever = (
            on_parent[0] + to_joint[0], on_parent[1] + to_joint[1], on_parent[2] + to_joint[2]
        )  # fmt: skip
        to_parent = _accelerated(a_P, w_P, dw_P, lever)
        base = (
            to_parent[0] + slides * (axis[0] * gain + 2.0 * across[0] * rate),
            to_parent[1] + slides * (axis[1] * gain + 2.0 * across[1] * rate),
            to_parent[2] + slides * (axis[2] * gain + 2.0 * across[2] * rate),
        )
        there = _accelerated(base, w[i], dw[i], on_joint)
        for j in range(3):
            acc[i, j] = there[j]
        rigid_tree.wrenches(
            rigid_tree.transposed_times(R[i], w[i]),
            rigid_tree.transposed_times(R[i], dw[i]),
            rigid_tree.transposed_times(R[i], acc[i]),
            force,
            moment,
        )
        for c in range(10):
            f, m = rigid_tree.times(R[i], force[c]), rigid_tree.times(R[i], moment[c])
            j = i
            while j >= 0:
                if tree.joint[j] == PRISMATIC:
                    out[tree.column[j], 10 * i + c] = _dot(axis_W[j], f)
                elif tree.joint[j] != FIXED:
                    arm = (p[i, 0] - anchor[j, 0], p[i, 1] - anchor[j, 1], p[i, 2] - anchor[j, 2])
                    twist = rigid_tree.cross(arm, f)
                    out[tree.column[j], 10 * i + c] = _dot(axis_W[j], m) + _dot(axis_W[j], twist)
                j = tree.parent[j]


@compilation.kernel
def _dot(a: Any, b: Any) -> float:
    """Scalar product of two vectors (3,)."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@compilation.kernel
def _accelerated(a: Any, w: Any, dw: Any, r: Any) -> Any:
    """Acceleration of a point at ``r`` of a body whose origin accelerates by ``a``, as a tuple."""
    spin = rigid_tree.cross(dw, r)
    turn = rigid_tree.cross(w, rigid_tree.cross(w, r))
    return (a[0] + spin[0] + turn[0], a[1] + spin[1] + turn[1], a[2] + spin[2] + turn[2])


@compilation.kernel
def equation_columns(
    tree: Any, groups: Any, gravity: Any, q: Any, v: Any, mass: Any, bias: Any, load: Any
) -> None:
    """Mass matrices (S, K, n, n), bias efforts and gravity loads (S, K, n) per group of parameters.

    ``groups`` (10 B, K) are inertial parameters per unit of each group.
    """
    samples, n = q.shape
    Y = np.zeros((n, groups.shape[0]))
    zero, still = np.zeros(n), np.zeros(3)
    for s in range(samples):
        regressor(tree, q[s], v[s], zero, gravity, Y)
        bias[s] = (Y @ groups).T
        regressor(tree, q[s], zero, zero, gravity, Y)
        load[s] = (Y @ groups).T
        for j in range(n):
            unit = np.zeros(n)
            unit[j] = 1.0
            regressor(tree, q[s], zero, unit, still, Y)
            mass[s, :, :, j] = (Y @ groups).T


@compilation.kernel
def delivered(command: Any, actuator: Any, dt: float, out: Any) -> None:
    """Mean effort (S, m) around each sample of commands (S, m) that are held until the next sample."""
    samples, m = command.shape
    for j in range(m):
        gain, limit, lag = actuator[j, GAIN], actuator[j, LIMIT], actuator[j, LAG]
        keep = np.exp(-dt / lag) if lag > 1e-9 else 0.0
        # Over one sample a lag that starts at x and is driven by u has the mean u + (x - u) r.
        r = (1.0 - keep) * lag / dt if lag > 1e-9 else 0.0
        shift = actuator[j, DELAY] / dt
        whole = int(np.floor(shift))
        part = shift - whole
        x = before = 0.0
        for s in range(samples):
            late = command[max(s - whole, 0), j]
            later = command[max(s - whole - 1, 0), j]
            first = min(max(gain * later, -limit), limit)
            second = min(max(gain * late, -limit), limit)
            if s == 0:
                x = second
                before = second
            # The first share of the sample still holds the earlier command.
            u = part * first + (1.0 - part) * second
            mean = u + (x - u) * r
            x = u + (x - u) * keep
            out[s, j] = 0.5 * (before + mean)
            before = mean


@compilation.kernel
def residual(
    output: Any, q: Any, v: Any, effort: Any, inputs: Any, mass: Any, bias: Any, load: Any,
    phi: Any, law: Any, pole: float, dt: float, out: Any,
) -> None:  # fmt: skip
    """Prediction error (S, n): the acceleration equation, through the observer that corrects it.

    ``output`` (S, n) are second differences of the measured positions, ``effort`` (S, m) delivered
    efforts, ``inputs`` (n, m) the joints they act on. A second difference of block means weighs the
    block before and after it with 1/8 each, and so is the model weighed.
    """
    samples, n = q.shape
    one, two = np.zeros(n), np.zeros(n)
    M, tau = np.zeros((n, n)), np.zeros(n)
    model = np.zeros((3, n))  # accelerations of the block before, this one and the next
    for s in range(samples + 1):
        for i in range(n):
            model[0, i] = model[1, i]
            model[1, i] = model[2, i]
            if s == samples:
                continue
            motor = 0.0
            for j in range(inputs.shape[1]):
                motor += inputs[i, j] * effort[s, j]
            gravity = bodies = 0.0
            for j in range(i + 1):  # solve() reads the lower triangle
                M[i, j] = 0.0
            for k in range(phi.size):
                if phi[k] != 0.0:
                    gravity += phi[k] * load[s, k, i]
                    bodies += phi[k] * bias[s, k, i]
                    for j in range(i + 1):
                        M[i, j] += phi[k] * mass[s, k, i, j]
            tau[i] = motor - bodies - joint.resistance(law[i], q[s, i], v[s, i], motor, gravity)
        if s < samples:
            solve(M, tau)
            model[2] = tau
        if s == 0:
            model[1] = tau
            continue
        for i in range(n):
            smeared = 0.125 * model[0, i] + 0.75 * model[1, i] + 0.125 * model[2, i]
            e = dt * dt * (output[s - 1, i] - smeared)
            e += 2.0 * pole * one[i] - pole * pole * two[i]
            out[s - 1, i] = e
            two[i] = one[i]
            one[i] = e


@compilation.kernel
def solve(M: Any, x: Any) -> None:
    """Solve M y = x in place for a symmetric positive M (n, n); NaN where it is not positive."""
    n = x.size
    for j in range(n):
        d = M[j, j]
        for k in range(j):
            d -= M[j, k] * M[j, k]
        d = np.sqrt(d) if d > 0.0 else np.nan
        M[j, j] = d
        for i in range(j + 1, n):
            t = M[i, j]
            for k in range(j):
                t -= M[i, k] * M[j, k]
            M[i, j] = t / d
    for i in range(n):
        for k in range(i):
            x[i] -= M[i, k] * x[k]
        x[i] /= M[i, i]
    for i in range(n - 1, -1, -1):
        for k in range(i + 1, n):
            x[i] -= M[k, i] * x[k]
        x[i] /= M[i, i]


@compilation.kernel
def pd_command(
    tree: Any, gravity: Any, carried: Any, reference: Any, rate: Any, position: Any, before: Any,
    law: Any, dt: float, Y: Any, out: Any,
) -> None:  # fmt: skip
    """Commands (n,) of joint PD with the gravity load of the parameters ``carried`` (10 B,)."""
    zero = np.zeros(position.size)
    regressor(tree, position, zero, zero, gravity, Y)
    load = Y @ carried
    for j in range(position.size):
        slope = rate[j] - (position[j] - before[j]) / dt
        u = law.kp[j] * (reference[j] - position[j]) + law.kd[j] * slope + load[j]
        out[j] = min(max(u, -law.limit[j]), law.limit[j])


@compilation.kernel
def replay_pd(
    tree: Any, gravity: Any, carried: Any, reference: Any, rate: Any, position: Any, law: Any,
    dt: float, command: Any,
) -> None:  # fmt: skip
    """Commands (S, n) of joint PD for logged positions (S, n)."""
    Y = np.zeros((position.shape[1], carried.size))
    for s in range(len(position)):
        pd_command(
            tree, gravity, carried, reference[s], rate[s], position[s], position[max(s - 1, 0)],
            law, dt, Y, command[s],
        )  # fmt: skip


@compilation.kernel
def simulate_pd(
    tree: Any, gravity: Any, phi: Any, nominal_gravity: Any, carried: Any, joints: Any,
    reference: Any, rate: Any, start: Any, law: Any, lsb: float, dt: float, substeps: int,
    position: Any, command: Any,
) -> None:  # fmt: skip
    """Closed loop of joint PD from the state ``start`` (2 n,): readings and commands (S, n)."""
    n = position.shape[1]
    x = start.copy()
    effort = np.zeros(n)
    Y = np.zeros((n, phi.size))
    for s in range(len(reference)):
        for i in range(n):
            position[s, i] = lsb * np.round(x[i] / lsb) if lsb > 0.0 else x[i]
        pd_command(
            tree, nominal_gravity, carried, reference[s], rate[s], position[s],
            position[max(s - 1, 0)], law, dt, Y, command[s],
        )  # fmt: skip
        advance(tree, gravity, phi, joints, command, s, x, effort, dt, substeps, Y)


@compilation.kernel
def advance(
    tree: Any, gravity: Any, phi: Any, joints: Any, command: Any, now: int, x: Any, effort: Any,
    dt: float, substeps: int, Y: Any,
) -> None:  # fmt: skip
    """One sample of the machine from state ``x`` (2 n,) and delivered ``effort`` (n,), both changed.

    Commands (S, n) up to row ``now`` are known; they are held from row to row. ``Y`` (n, 10 B) is scratch.
    """
    n = effort.size
    h = dt / substeps
    for k in range(substeps):
        for j in range(n):
            row = joints.actuator[j]
            keep = np.exp(-h / row[LAG]) if row[LAG] > 1e-9 else 0.0
            u = joint.held_command(command, now * dt + k * h, row[DELAY], dt, j)
            wanted = min(max(row[GAIN] * u, -row[LIMIT]), row[LIMIT])
            effort[j] = wanted + (effort[j] - wanted) * keep
        k1 = _slope(tree, gravity, phi, joints.law, x, effort, Y)
        k2 = _slope(tree, gravity, phi, joints.law, x + 0.5 * h * k1, effort, Y)
        k3 = _slope(tree, gravity, phi, joints.law, x + 0.5 * h * k2, effort, Y)
        k4 = _slope(tree, gravity, phi, joints.law, x + h * k3, effort, Y)
        x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)


@compilation.kernel
def _slope(tree: Any, gravity: Any, phi: Any, law: Any, x: Any, effort: Any, Y: Any) -> Any:
    """Rates (2 n,) of positions and speeds."""
    n = effort.size
    q, v, zero, still = x[:n], x[n:], np.zeros(n), np.zeros(3)
    M, tau = np.zeros((n, n)), np.zeros(n)
    regressor(tree, q, zero, zero, gravity, Y)
    load = Y @ phi
    regressor(tree, q, v, zero, gravity, Y)
    bias = Y @ phi
    for j in range(n):
        unit = np.zeros(n)
        unit[j] = 1.0
        regressor(tree, q, zero, unit, still, Y)
        M[:, j] = Y @ phi
        tau[j] = effort[j] - bias[j] - joint.resistance(law[j], q[j], v[j], effort[j], load[j])
    solve(M, tau)
    return np.concatenate((v, tau))
