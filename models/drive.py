r"""An n-shaft electromechanical drive with constant inertia: the law behind C-drive and slider.

.. math:: M \ddot q + E^T f(E \dot q) + h(q) = \tau

1. :math:`q` (n,) shaft positions, :math:`\tau` (n,) torques that reach the shafts;
2. :math:`E` (m, n) maps shaft speeds to the speeds of the m friction elements (a shaft's own
   bearing, or the nut between two shafts), :math:`f` (m,) their friction, ``friction.py``;
3. :math:`h(q) = b + r_c \cos(kq) + r_s \sin(kq)` (n,): bias load and torque ripple of the motor;
4. from command :math:`u` to torque: delay, gain, limit, lag of first or second order, in this order, and
   load-dependent friction proportional to the magnitude of the drive torque, its ripple included, or to that of
   what the bias leaves of it: what is transmitted behind the place where the bias acts.

5. a coupling between two shafts: :math:`k \,\mathrm{dz}(\Delta q, g/2) + c \Delta\dot q` in contact,
   dz the dead zone of the clearance g.

Rotary shafts use rad and N m, linear ones m and N. Not modelled here: posture-dependent inertia.
"""

from typing import Any, NamedTuple

import numpy as np

from . import control, elementary, friction, runge_kutta

# Columns of ``Drive.element``, the constants of a friction element.
(
    VISCOUS,  # [N m s/rad or N s/m]
    VISCOUS_SKEW,  # what the coefficient has more forward, less backward [N m s/rad or N s/m]
    FORWARD,  # dry friction at positive speed [N m or N]
    BACKWARD,  # dry friction at negative speed [N m or N]
    BREAKAWAY,  # dry friction at standstill beyond the sliding level [N m or N]
    STRIBECK_SPEED,  # [rad/s or m/s]
    WIDTH,  # smoothing of the sign [rad/s or m/s]
    STIFFNESS,  # presliding stiffness, 0 for the smoothed sign [N m/rad or N/m]
    FADE,  # rate at which the element's sliding friction dies away with time [1/s]
    STRIBECK_EXPONENT,  # shape of the decay from breakaway, a number and never a variable [-]
) = range(ELEMENT_COLUMNS := 10)

# Columns of ``Drive.shaft``, the constants of a shaft and its actuator.
(
    LOAD_FRICTION,  # dry friction per magnitude of drive torque [-]
    BIAS,  # load that opposes positive torque [N m or N]
    RIPPLE_COS,  # [N m or N]
    RIPPLE_SIN,  # [N m or N]
    RIPPLE_WAVENUMBER,  # k [1/rad or 1/m]
    LOAD_WIDTH,  # smoothing of the sign in load-dependent friction [rad/s or m/s]
    NET_LOAD_FRICTION,  # dry friction per magnitude of what the bias leaves of the drive torque [-]
    DELAY,  # of the command [s]
    GAIN,  # torque delivered per torque commanded [-]
    LIMIT,  # largest torque magnitude [N m or N]
    LAG,  # time constant of the torque loop [s]
    STAGES,  # equal first-order stages that share the lag, 1 or 2
) = range(SHAFT_COLUMNS := 12)

# Columns of ``Drive.coupling``, a flexible connection from one shaft to another.
(
    FROM_SHAFT,  # number of the driving shaft
    TO_SHAFT,  # number of the driven shaft
    COUPLING_STIFFNESS,  # [N m/rad or N/m]
    COUPLING_DAMPING,  # [N m s/rad or N s/m]
    GAP,  # whole clearance [rad or m]
) = range(COUPLING_COLUMNS := 5)


class Drive(NamedTuple):
    """Constants of one drive as arrays, so that kernels, batches and contexts can share them."""

    inertia_inverse: Any  # (n, n) inverse of M [1/(kg m^2) or 1/kg]
    elements: Any  # (m, n) E, speed of each friction element per shaft speed [-]
    element: Any  # (m, 10) constants of the friction elements, columns above
    shaft: Any  # (n, 12) constants of the shafts, columns above
    coupling: Any  # (c, 5) flexible couplings between two shafts, columns above

    def copy(self) -> "Drive":
        """A drive whose arrays can be changed without changing this one."""
        return Drive(*(np.array(field) for field in self))


def ideal_drive(inertia: Any, elements: Any, viscous: Any, width: float) -> Drive:
    """Drive with viscous friction only, from M (n, n), E (m, n), coefficients (m,) and sign width."""
    m, n = np.shape(elements)
    element = np.zeros((m, ELEMENT_COLUMNS))
    element[:, VISCOUS] = viscous
    element[:, STRIBECK_SPEED] = 10.0 * width
    element[:, STRIBECK_EXPONENT] = 2.0
    element[:, WIDTH] = width
    shaft = np.zeros((n, SHAFT_COLUMNS))
    shaft[:, RIPPLE_WAVENUMBER] = 1.0
    shaft[:, GAIN] = 1.0
    shaft[:, LIMIT] = np.inf
    shaft[:, STAGES] = 1.0
    shaft[:, LOAD_WIDTH] = width
    return Drive(
        np.linalg.inv(inertia),
        np.array(elements, dtype=float),
        element,
        shaft,
        np.zeros((0, COUPLING_COLUMNS)),
    )


def acceleration(
    q: Any, v: Any, held: Any, torque: Any, t: Any, drive: Drive, work: Any, out: Any
) -> None:
    """Solve the equation of motion (1) for the accelerations ``out`` (n,).

    ``held`` (m,) are element forces that do not follow ``v`` (presliding), ``torque`` (n,) reaches the
    shafts at time ``t`` [s]; ``work`` (n,) is overwritten. Arrays may hold floats, AutoDiffXd or
    Expressions.
    """
    n = drive.elements.shape[1]
    net_torque(q, v, held, torque, t, drive, work)
    for c in range(drive.coupling.shape[0]):
        i, j = _shafts(drive.coupling, c)
        force = coupling_force(
            q[i] - q[j],
            v[i] - v[j],
            drive.coupling[c, COUPLING_STIFFNESS],
            drive.coupling[c, COUPLING_DAMPING],
            drive.coupling[c, GAP],
        )
        work[i] -= force
        work[j] += force
    for j in range(n):
        out[j] = drive.inertia_inverse[j, 0] * work[0]
        for k in range(1, n):
            out[j] += drive.inertia_inverse[j, k] * work[k]


def net_torque(q: Any, v: Any, held: Any, torque: Any, t: Any, drive: Drive, out: Any) -> None:
    """Torques ``out`` (n,) that are left to accelerate the shafts, without couplings: eqs. (2)-(4)."""
    m, n = drive.elements.shape
    for j in range(n):
        driving = torque[j] - ripple(
            q[j],
            drive.shaft[j, RIPPLE_COS],
            drive.shaft[j, RIPPLE_SIN],
            drive.shaft[j, RIPPLE_WAVENUMBER],
        )
        out[j] = driving - drive.shaft[j, BIAS]
        if drive.shaft[j, LOAD_FRICTION] != 0.0 or drive.shaft[j, NET_LOAD_FRICTION] != 0.0:
            level = drive.shaft[j, LOAD_FRICTION] * np.abs(driving) + drive.shaft[
                j, NET_LOAD_FRICTION
            ] * np.abs(out[j])
            out[j] -= level * friction.smooth_sign(v[j], drive.shaft[j, LOAD_WIDTH])
    for i in range(m):
        speed = drive.elements[i, 0] * v[0]
        for j in range(1, n):
            speed += drive.elements[i, j] * v[j]
        force = friction.viscous(speed, drive.element[i, VISCOUS], drive.element[i, VISCOUS_SKEW])
        if drive.element[i, STIFFNESS] == 0.0 and (
            drive.element[i, FORWARD] != 0.0 or drive.element[i, BACKWARD] != 0.0
        ):
            peak = 0.0 * speed
            if drive.element[i, BREAKAWAY] != 0.0:
                peak = friction.stribeck_peak(
                    speed,
                    drive.element[i, BREAKAWAY],
                    drive.element[i, STRIBECK_SPEED],
                    drive.element[i, STRIBECK_EXPONENT],
                )
            force += friction.sliding(
                speed,
                drive.element[i, FORWARD],
                drive.element[i, BACKWARD],
                peak,
                drive.element[i, WIDTH],
            )
        if drive.element[i, FADE] != 0.0:
            force *= np.exp(-t * drive.element[i, FADE])
        if drive.element[i, STIFFNESS] != 0.0:
            force += held[i]
        for j in range(n):
            out[j] -= drive.elements[i, j] * force


def ripple(q: Any, cos: Any, sin: Any, wavenumber: Any) -> Any:
    """What the motor's torque lacks at position ``q``, the ripple of eq. (3)."""
    if cos == 0.0 and sin == 0.0:
        return 0.0
    return cos * np.cos(wavenumber * q) + sin * np.sin(wavenumber * q)


def _shafts(coupling: Any, c: int) -> tuple[int, int]:
    """Numbers of the driving and the driven shaft."""
    return (
        elementary.whole(coupling[c, FROM_SHAFT]),
        elementary.whole(coupling[c, TO_SHAFT]),
    )


def coupling_force(twist: Any, rate: Any, stiffness: Any, damping: Any, gap: Any) -> Any:
    """Force (5) of a flexible coupling; with a clearance, it pushes and damps in contact only."""
    half = 0.5 * gap
    if half == 0.0:
        return stiffness * twist + damping * rate
    ahead = max(0.0, stiffness * (twist - half) + damping * rate)
    behind = min(0.0, stiffness * (twist + half) + damping * rate)
    return elementary.where(twist > half, ahead, elementary.where(twist < -half, behind, 0.0))


def held_friction(v: Any, z: Any, dt: float, drive: Drive, out: Any) -> None:
    """Mean bristle forces ``out`` (m,) over one step; moves the deflections ``z`` (m,) on."""
    m, n = drive.elements.shape
    for i in range(m):
        out[i] = 0.0
        if drive.element[i, STIFFNESS] != 0.0:
            speed = drive.elements[i, 0] * v[0]
            for j in range(1, n):
                speed += drive.elements[i, j] * v[j]
            level = elementary.where(
                speed > 0.0, drive.element[i, FORWARD], drive.element[i, BACKWARD]
            )
            if drive.element[i, BREAKAWAY] != 0.0:  # LuGre's g(v)
                level += friction.stribeck_peak(
                    speed,
                    drive.element[i, BREAKAWAY],
                    drive.element[i, STRIBECK_SPEED],
                    drive.element[i, STRIBECK_EXPONENT],
                )
            after = friction.bristle_step(speed, z[i], drive.element[i, STIFFNESS], level, dt)
            out[i] = 0.5 * drive.element[i, STIFFNESS] * (z[i] + after)
            z[i] = after


def deliver_torques(k: int, command: Any, lag: Any, dt: float, drive: Drive, out: Any) -> None:
    """Mean torques ``out`` of the actuated shafts during sample ``k`` of ``command`` (samples, n), eq. (4).

    Moves the states ``lag`` (2, n) of both stages on; their size says how many shafts are actuated.
    """
    for j in range(lag.shape[1]):
        late = delayed_command(command, k, j, drive.shaft[j, DELAY], dt)
        out[j], lag[0, j], lag[1, j] = delivered_torque(
            late,
            lag[0, j],
            lag[1, j],
            drive.shaft[j, GAIN],
            drive.shaft[j, LIMIT],
            drive.shaft[j, LAG],
            drive.shaft[j, STAGES],
            dt,
        )


def work_arrays(n: int) -> tuple[Any, ...]:
    """Scratch for ``ode4_step`` with ``n`` shafts: that of ``acceleration`` and that of the step."""
    return np.zeros(n), runge_kutta.work_arrays(n)


def ode4_step(
    q: Any, v: Any, held: Any, torque: Any, t: float, dt: float, drive: Drive, work: Any
) -> None:
    """One classical Runge-Kutta step of (1) in place, torque and held friction constant over it.

    ``work`` is the scratch of ``work_arrays``.
    """
    scratch, stages = work
    runge_kutta.ode4_step(
        acceleration, q.shape[0], q, v, held, torque, t, dt, drive, scratch, stages
    )


def delayed_command(command: Any, k: int, j: int, delay: float, dt: float) -> float:
    """Command (samples, n) of shaft ``j`` that acts during sample ``k``, ``delay`` seconds late.

    The mean over the sample of the held command; before the first sample the command is the first.
    """
    if delay == 0.0:
        return command[k, j]
    samples = delay / dt
    whole = elementary.whole(samples)
    part = samples - whole
    newer = command[max(k - whole, 0), j]
    older = command[max(k - whole - 1, 0), j]
    return newer + part * (older - newer)


def delivered_torque(
    command: float,
    first: float,
    second: float,
    gain: float,
    limit: float,
    lag: float,
    stages: float,
    dt: float,
) -> tuple[float, float, float]:
    r"""Torque of one actuator: its mean over a sample of held ``command``, and both stages' next state.

    With one stage the second one's state is not used. With two, both have the time constant lag / 2:
    :math:`\tau_2 = u + (x_2 + x_1 t / T) e^{-t/T}`, :math:`x_i` the states less u.
    """
    target = control.clip(gain * command, limit)
    if lag == 0.0:
        return target, target, target
    ratio = lag / (stages * dt)
    decay = np.exp(-1.0 / ratio)
    x1, x2 = first - target, second - target
    after = target + x1 * decay
    if stages != 2.0:
        return target + x1 * ratio * (1.0 - decay), after, after
    mean = ratio * ((x1 + x2) * (1.0 - decay) - x1 * decay / ratio)
    return target + mean, after, target + (x2 + x1 / ratio) * decay
