r"""The C-drive loop as a fixed-step block diagram: every continuous block integrated by ODE4 together.

The thesis ran its simulation in Simulink with ODE4 at 1 ms (Friedlaender 2015, Table 5-3). There the
derivative filter and the observer are continuous blocks, integrated with the plant; the encoder, the
error and the torque are evaluated at the minor steps as well; only the unit delay of Fig. 4-2 is sampled.
A real-time controller, ``drive_kernels.simulate``, holds its inputs and its torque over a sample instead.

State rows: shaft positions q, speeds, low-passed errors of the filter (5.1), observer states kappa.

.. math:: \dot x = (\dot q, \ddot q, N (e - x_f), U \kappa + V \psi + Z \tau_{k-1})

``Wiring`` moves holds and delays about, to find out what the thesis did. Laws are those of
``control.py``, ``drive.py`` and ``encoder.py``. Not modelled here: command delay in fractions of a sample,
torque lag, presliding and flexible couplings of the drive.
"""

from typing import Any, NamedTuple

import numpy as np

from . import compilation, control, drive, encoder, friction
from .drive import Drive
from .drive_kernels import LoopController
from .observer import ContinuousObserver

compilation.register_laws(friction, encoder, control, drive)

POSITION, SPEED, FILTERED, OBSERVED = range(4)


class Wiring(NamedTuple):
    """Where signals are quantised, held and delayed; the defaults are Fig. 4-2 with continuous blocks."""

    lsb: float  # step of the encoder [rad], 0 for an exact one
    encoder_shift: float = 0.0  # added before rounding [rad]; -lsb/2 rounds down
    dead_zone: float = 0.0  # half width of the dead zone on the error of the servo law [rad]
    hold_position: bool = False  # the controller sees the position of the major step only
    hold_command: bool = False  # the torque is computed at major steps and held
    observer_late: bool = True  # the observer sees the torque of one step ago, the block 1/z
    position_late: bool = False  # the controller sees the position of one step ago (and held)
    filter_position: bool = False  # derivative of the error as r' - F(s) q instead of F(s) e


class BlockController(NamedTuple):
    """Gains as in ``LoopController`` (its sampled observer is not used) and continuous observer."""

    gains: LoopController
    observer: ContinuousObserver
    wiring: Wiring


@compilation.kernel
def simulate_blocks(
    reference: Any,
    reference_rate: Any,
    reference_acceleration: Any,
    plant: Drive,
    controller: BlockController,
    dt: float,
    position: Any,
    command: Any,
) -> None:
    """Closed loop from rest at zero: writes what the encoder reads and the command, (samples, n).

    The references (2 samples + 1, n) are given at every half step. Of the plant's actuator, gain and
    limit act; the shafts see the torque of the current minor step.
    """
    samples, n = position.shape
    w = controller.wiring
    x = np.zeros((4, n))
    stage_x = np.zeros((4, n))
    total = np.zeros((4, n))
    slope = np.zeros((4, n))
    measured, held_position, before = np.zeros(n), np.zeros(n), np.zeros(n)
    torque, late_torque = np.zeros(n), np.zeros(n)
    work = (np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n))
    for k in range(samples):
        stage_x[:] = x
        total[:] = 0.0
        for j in range(n):
            late_torque[j] = command[max(k - 1, 0), j]
            before[j] = held_position[j]
            held_position[j] = encoder.read(x[POSITION, j] + w.encoder_shift, w.lsb)
        for stage in range(4):
            half_step = 0 if stage == 0 else (2 if stage == 3 else 1)
            for j in range(n):
                measured[j] = encoder.read(stage_x[POSITION, j] + w.encoder_shift, w.lsb)
                if w.position_late:
                    measured[j] = before[j]
                elif w.hold_position:
                    measured[j] = held_position[j]
            at = 2 * k + (0 if w.hold_command else half_step)
            if stage == 0 or not w.hold_command:
                _torque(
                    reference[at],
                    reference_rate[at],
                    reference_acceleration[at],
                    measured,
                    stage_x,
                    controller,
                    torque,
                    work,
                )
            if stage == 0:
                position[k] = held_position
                command[k] = torque
            _slope(
                reference[at],
                measured,
                torque,
                late_torque,
                stage_x,
                plant,
                controller,
                k * dt + 0.5 * half_step * dt,
                slope,
                work,
            )
            weight = 2.0 if stage in (1, 2) else 1.0
            following = dt if stage == 2 else 0.5 * dt
            for i in range(4):
                for j in range(n):
                    total[i, j] += weight * slope[i, j]
                    stage_x[i, j] = x[i, j] + following * slope[i, j]
        for i in range(4):
            for j in range(n):
                x[i, j] += dt / 6.0 * total[i, j]


@compilation.kernel
def _filter_input(reference: float, measured: float, w: Wiring) -> float:
    if w.filter_position:
        return -measured
    return control.dead_zone(reference - measured, w.dead_zone)


@compilation.kernel
def _torque(
    reference: Any,
    reference_rate: Any,
    reference_acceleration: Any,
    measured: Any,
    x: Any,
    controller: BlockController,
    torque: Any,
    work: Any,
) -> None:
    """Control law (4.32), (4.37) or (4.35) at one minor step."""
    c, w = controller.gains, controller.wiring
    error, derivative, rate, servo, _ = work
    for j in range(len(torque)):
        error[j] = control.dead_zone(reference[j] - measured[j], w.dead_zone)
        signal = _filter_input(reference[j], measured[j], w)
        derivative[j] = control.filtered_derivative(signal, x[FILTERED, j], c.cutoff)
        if w.filter_position:
            derivative[j] += reference_rate[j]
    for i in range(len(torque)):
        rate[i] = control.row(i, controller.observer.rate_from_state, x[OBSERVED])
        rate[i] += control.row(i, controller.observer.rate_from_position, measured)
        servo[i] = (
            c.feedforward * reference_acceleration[i]
            + control.row(i, c.kp, error)
            + control.row(i, c.kd, derivative)
        )
    for i in range(len(torque)):
        value = control.row(i, c.output, servo) + control.row(i, c.friction, rate)
        torque[i] = control.clip(value, c.limit)


@compilation.kernel
def _slope(
    reference: Any,
    measured: Any,
    torque: Any,
    late_torque: Any,
    x: Any,
    plant: Drive,
    controller: BlockController,
    t: float,
    slope: Any,
    work: Any,
) -> None:
    """Time derivative of the state (4, n) at one minor step."""
    c, w, observer = controller.gains, controller.wiring, controller.observer
    delivered, scratch, accelerations, seen, _ = work
    for j in range(len(torque)):
        delivered[j] = control.clip(
            plant.shaft[j, drive.GAIN] * torque[j], plant.shaft[j, drive.LIMIT]
        )
        seen[j] = late_torque[j] if w.observer_late else torque[j]
    no_presliding = np.zeros(plant.elements.shape[0])
    drive.acceleration(
        x[POSITION], x[SPEED], no_presliding, delivered, t, plant, scratch, accelerations
    )
    for j in range(len(torque)):
        signal = _filter_input(reference[j], measured[j], w)
        slope[POSITION, j] = x[SPEED, j]
        slope[SPEED, j] = accelerations[j]
        slope[FILTERED, j] = control.filtered_derivative(signal, x[FILTERED, j], c.cutoff)
        slope[OBSERVED, j] = control.row(j, observer.from_state, x[OBSERVED])
        slope[OBSERVED, j] += control.row(j, observer.from_position, measured)
        slope[OBSERVED, j] += control.row(j, observer.from_torque, seen)
