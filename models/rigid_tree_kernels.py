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
    turn = np.zeros((3, 3))
    force, moment = np.zeros((10, 3)), np.zeros((10, 3))
    out[:] = 0.0
    for i in range(bodies):
        up = tree.parent[i]
        R_P, p_P = np.eye(3), np.zeros(3)
        w_P, dw_P, a_P = np.zeros(3), np.zeros(3), -gravity
        if up >= 0:
            R_P, p_P, w_P, dw_P, a_P = R[up], p[up], w[up], dw[up], acc[up]
        R_F = R_P @ tree.R_PF[i]
        p_F = p_P + R_P @ tree.p_PF[i]
        axis = R_F @ tree.axis[i]
        k = tree.column[i]
        kind = tree.joint[i]
        rigid_tree.rotation(tree.axis[i], q[k] if kind == REVOLUTE else 0.0, turn)
        R_M = R_F @ turn
        p_M = p_F + axis * (q[k] if kind == PRISMATIC else 0.0)
        R[i] = R_M @ tree.R_MB[i]
        p[i] = p_M + R_M @ tree.p_MB[i]
        axis_W[i], anchor[i] = axis, p_F
        w[i], dw[i] = w_P, dw_P
        if kind == REVOLUTE:
            w[i] += axis * v[k]
            dw[i] += axis * a[k] + np.array(rigid_tree.cross(w_P, axis)) * v[k]
        _accelerate(a_P, w_P, dw_P, p_M - p_P, acc[i])
        if kind == PRISMATIC:
            acc[i] += axis * a[k] + 2.0 * np.array(rigid_tree.cross(w_P, axis)) * v[k]
        shifted = np.zeros(3)
        _accelerate(acc[i], w[i], dw[i], p[i] - p_M, shifted)
        acc[i] = shifted
        R_BW = R[i].T
        rigid_tree.wrenches(R_BW @ w[i], R_BW @ dw[i], R_BW @ acc[i], force, moment)
        for c in range(10):
            f, m = R[i] @ force[c], R[i] @ moment[c]
            j = i
            while j >= 0:
                if tree.joint[j] == PRISMATIC:
                    out[tree.column[j], 10 * i + c] = axis_W[j] @ f
                elif tree.joint[j] != FIXED:
                    total = m + np.array(rigid_tree.cross(p[i] - anchor[j], f))
                    out[tree.column[j], 10 * i + c] = axis_W[j] @ total
                j = tree.parent[j]


@compilation.kernel
def _accelerate(a: Any, w: Any, dw: Any, r: Any, out: Any) -> None:
    """Acceleration of a point at ``r`` of a body whose origin accelerates by ``a``, to ``out``."""
    spin = rigid_tree.cross(dw, r)
    turn = rigid_tree.cross(w, rigid_tree.cross(w, r))
    for k in range(3):
        out[k] = a[k] + spin[k] + turn[k]


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
    h = dt / substeps
    for s in range(len(reference)):
        for i in range(n):
            position[s, i] = lsb * np.round(x[i] / lsb) if lsb > 0.0 else x[i]
        pd_command(
            tree, nominal_gravity, carried, reference[s], rate[s], position[s],
            position[max(s - 1, 0)], law, dt, Y, command[s],
        )  # fmt: skip
        for k in range(substeps):
            for j in range(n):
                row = joints.actuator[j]
                keep = np.exp(-h / row[LAG]) if row[LAG] > 1e-9 else 0.0
                u = joint.held_command(command, s * dt + k * h, row[DELAY], dt, j)
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
