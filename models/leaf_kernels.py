"""Compiled laws for LeafSystems: one call a callback, on arrays as a Context has them.

Constants come flattened by rows, as numeric parameters are.
"""

from typing import Any

import numpy as np

from . import compilation, control, drive, drive_kernels, encoder
from .drive import Drive

compilation.register_laws(control, drive, encoder)


@compilation.kernel
def pid(kp: Any, ki: Any, kd: Any, error: Any, integral: Any, slope: Any, out: Any) -> None:
    """All rows (n,) of ``control.pid``; gains (n n,)."""
    n = error.size
    gains = kp.reshape(n, n), ki.reshape(n, n), kd.reshape(n, n)
    for i in range(n):
        out[i] = control.pid(i, gains[0], gains[1], gains[2], error, integral, slope)


@compilation.kernel
def deliver(
    actuator: Any, state: Any, command: Any, period: float, torque: Any, after: Any
) -> None:
    """Torques (n,) of a ``TorqueAmplifier`` during the sample that begins, and its next state.

    ``actuator`` (n 5,) are the last columns of ``Drive.shaft``.
    """
    n = command.size
    constants = actuator.reshape(n, 5)
    past = (state.size - 2 * n - 1) // n
    commands = np.empty((past + 1, n))
    for j in range(n):
        for k in range(past):
            began = state[2 * n] > 0.0
            commands[k, j] = state[2 * n + 1 + n * k + j] if began else command[j]
        commands[past, j] = command[j]
        late = drive.delayed_command(commands, past, j, constants[j, 0], period)
        torque[j], after[j], after[n + j] = drive.delivered_torque(
            late,
            state[j],
            state[n + j],
            constants[j, 1],
            constants[j, 2],
            constants[j, 3],
            constants[j, 4],
            period,
        )
        for k in range(past):
            after[2 * n + 1 + n * k + j] = commands[k + 1, j]
    after[2 * n] = 1.0


@compilation.kernel
def move(
    state: Any,
    torque: Any,
    t: float,
    period: float,
    substeps: int,
    inertia_inverse: Any,
    elements: Any,
    element: Any,
    load: Any,
    joined: Any,
    coupling: Any,
    after: Any,
) -> None:
    """State of a ``SampledDrivePlant`` one sample later: positions, speeds and bristle deflections.

    ``elements`` (m, n), ``joined`` (c, 2) the shafts of each coupling; the other constants are those of
    ``drive_law.Drive``, flattened: ``element``, the columns of ``shaft`` that are a load, the rest of ``coupling``.
    """
    m, n = elements.shape
    c = joined.shape[0]
    plant = Drive(
        inertia_inverse.reshape(n, n),
        elements,
        element.reshape(m, drive.ELEMENT_COLUMNS),
        load.reshape(n, drive.DELAY),
        np.empty((c, drive.COUPLING_COLUMNS)),
    )
    plant.coupling[:, : drive.COUPLING_STIFFNESS] = joined
    plant.coupling[:, drive.COUPLING_STIFFNESS :] = coupling.reshape(
        c, drive.COUPLING_COLUMNS - drive.COUPLING_STIFFNESS
    )
    after[:] = state
    torques = np.zeros(n)
    torques[: torque.size] = torque
    drive_kernels.move(
        after[:n], after[n : 2 * n], after[2 * n :], np.zeros(m), torques, t, plant, period, substeps,
        drive.work_arrays(n),
    )  # fmt: skip


@compilation.kernel
def advance_encoded(
    command: Any, t: float, shafts: int, constants: Any, state: Any, measured: Any
) -> None:
    """Move the state of an ``EncodedDrive`` on by a sample and read it; ``constants`` are those of ``encoded``."""
    period, substeps, lsb = constants[0], int(constants[1]), constants[2]
    motors = command.size
    m = state.size - 2 * (shafts + motors)
    first = 3 + shafts * shafts
    second = first + m * shafts
    third = second + m * drive.ELEMENT_COLUMNS
    fourth = third + shafts * drive.SHAFT_COLUMNS
    joined = constants[fourth:]
    plant = Drive(
        constants[3:first].reshape(shafts, shafts),
        constants[first:second].reshape(m, shafts),
        constants[second:third].reshape(m, drive.ELEMENT_COLUMNS),
        constants[third:fourth].reshape(shafts, drive.SHAFT_COLUMNS),
        joined.reshape(joined.size // drive.COUPLING_COLUMNS, drive.COUPLING_COLUMNS),
    )
    q, v, z = state[:shafts], state[shafts : 2 * shafts], state[2 * shafts : 2 * shafts + m]
    lag = state[2 * shafts + m :].reshape(2, motors)
    torque = np.zeros(shafts)
    drive.deliver_torques(0, command.reshape(1, motors), lag, period, plant, torque)
    drive_kernels.move(
        q, v, z, np.zeros(m), torque, t, plant, period, substeps, drive.work_arrays(shafts)
    )
    for j in range(motors):
        measured[j] = encoder.read(q[j], lsb)


def encoded(plant: Drive, period: float, substeps: int, lsb: float) -> Any:
    """Sample time [s], its steps, the encoders' count and the arrays of a drive, flattened by rows, in one array."""
    return np.concatenate([[period, substeps, lsb], *(np.ravel(part) for part in plant)])
