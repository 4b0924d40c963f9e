"""Bandwidth of the 2PRU-1PRS table: closed position loops in z, psi and theta (Roldan, section 4.2.4).

Sines of the platform pass through the inverse kinematics to three cascaded axes, whose load is the table's inertia and
weight in its home posture; the platform follows by forward kinematics. Response and phase are those of the
fundamental of the last whole cycles.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...models import servo_kernels
from ...models.belt_axis import IDENTIFIED, MANUFACTURER, BeltAxis
from ...models.belt_control import Gains
from ...models.parallel import mast, prs
from ...models.parallel.prs import Table
from ...models.servo_kernels import Axes

Array = NDArray[np.float64]

# Assumed sizes: in z it gives the printed difference of torques at 10 Hz, and the tilts move a slider about as far.
MOTIONS = {
    "z": (0, 4e-3),
    "psi": (1, np.deg2rad(0.65)),
    "theta": (2, np.deg2rad(0.65)),
}
FREQUENCIES = (0.4, 0.5, 1.0, 2.0, 3.0, 3.5, 4.0, 4.5, 5.0, 7.0, 10.0, 14.0, 20.0)  # [Hz]
PRINTED = {0.4: (0.994, -6.3), 5.0: (0.654, -62.5), 10.0: (0.432, -103.7)}  # gain, phase [deg]
PRINTED_BANDWIDTH = {"axes alone": 4.0, "with the table": 3.5}  # [Hz]
HOME = np.array([mast.MAST.home, 0.0, 0.0])
SUBSTEPS = 20
SIGN_RATE = 10.78  # beta of the 5R's axes, none is printed for the table [s/rad]


@dataclass(frozen=True, kw_only=True)
class Response:
    """One motion at all frequencies."""

    motion: str
    load: str  # "with the table" or "axes alone"
    frequencies: Array  # [Hz]
    gain: Array  # [-]
    phase: Array  # [deg]
    torque: Array  # (frequencies, 3), amplitudes of the motors' fundamentals [N m]

    @property
    def bandwidth(self) -> float:
        """Frequency of -3 dB, between frequencies on a line in log frequency [Hz]; NaN if none."""
        return _crossing(
            self.frequencies, 20.0 * np.log10(self.gain), -20.0 * np.log10(np.sqrt(2.0))
        )

    @property
    def misfit(self) -> tuple[float, float]:
        """Largest departures from what is printed: of the gain, and of the phase [deg]."""
        at = [int(np.flatnonzero(self.frequencies == f)[0]) for f in PRINTED]
        gain, phase = np.array(list(PRINTED.values())).T
        return (
            float(np.abs(self.gain[at] - gain).max()),
            float(np.abs(self.phase[at] - phase).max()),
        )

    @property
    def phase_bandwidth(self) -> float:
        """Frequency of -45 deg [Hz]."""
        return _crossing(self.frequencies, self.phase, -45.0)


@dataclass(frozen=True, kw_only=True)
class TorqueComparison:
    """Manufacturers' against identified values in the z motion: Figs. 4.24-4.26."""

    frequency: float  # [Hz]
    manufacturer: float  # largest motor torque of axis 1 less its mean [N m]
    identified: float

    @property
    def relative(self) -> float:
        """Difference, relative to the identified machine."""
        return self.manufacturer / self.identified - 1.0


def axes(axis: BeltAxis, *, table: bool, model: Table = mast.MAST) -> Axes:
    """Plant of three axes, alone or under the table in its home posture."""
    inertia, load = (axis.driving + axis.driven) * np.eye(3), np.zeros(3)
    if table:
        at = prs.dynamics(prs.inverse(HOME, model), np.zeros(3), model, HOME)
        inertia = inertia + axis.per_motor**2 * at.inertia
        load = axis.per_motor * at.gravity
    return Axes(np.linalg.inv(inertia), load, 0.0, axis.coulomb, SIGN_RATE, axis.torque_constant)


def simulate(
    motion: str,
    frequency: float,
    axis: BeltAxis,
    gains: Gains,
    *,
    table: bool,
    size: float | None = None,
    model: Table = mast.MAST,
) -> tuple[Array, Array, Array, Array]:
    """Times (samples,), commanded and followed tasks (samples, 3), motor torques (samples, 3).

    ``size`` of the sine [m or rad], by default that of ``MOTIONS``.
    """
    index, usual = MOTIONS[motion]
    size = usual if size is None else size
    cycles = max(3, int(np.ceil(2.0 * frequency)))
    samples = int(np.ceil(cycles / frequency / gains.velocity_period))
    t: Array = gains.velocity_period * np.arange(samples, dtype=float)
    loops = gains.loops(MANUFACTURER)
    task: Array = np.tile(HOME, (samples, 1))
    task[:, index] += size * np.sin(2.0 * np.pi * frequency * t)
    reference = prs.inverse(task, mast.MAST) / axis.per_motor
    angle, torque = np.empty((samples, 3)), np.empty((samples, 3))
    coarse = np.ascontiguousarray(reference[:: loops.ratio])
    plant = axes(axis, table=table, model=model)
    servo_kernels.simulate(coarse, np.zeros_like(coarse), plant, loops, SUBSTEPS, angle, torque)
    return t, task, prs.forward(angle * axis.per_motor, mast.MAST), torque


def response(
    motion: str,
    axis: BeltAxis = IDENTIFIED,
    gains: Gains | None = None,
    *,
    table: bool = True,
    frequencies: tuple[float, ...] = FREQUENCIES,
    size: float | None = None,
    model: Table = mast.MAST,
) -> Response:
    """Closed-loop response of one motion."""
    rows = []
    for f in frequencies:
        t, task, followed, torque = simulate(
            motion, f, axis, gains or Gains(), table=table, size=size, model=model
        )
        index, _ = MOTIONS[motion]
        last = t >= t[-1] - 1.0 / f * np.floor(max(1.0, f * 0.5 * t[-1]))
        asked, got = (_fundamental(x[last, index], t[last], f) for x in (task, followed))
        rows.append((got / asked, [abs(_fundamental(x, t[last], f)) for x in torque[last].T]))
    ratio = np.array([r for r, _ in rows])
    return Response(
        motion=motion,
        load="with the table" if table else "axes alone",
        frequencies=np.array(frequencies),
        gain=np.abs(ratio),
        phase=np.rad2deg(np.unwrap(np.angle(ratio))),
        torque=np.array([a for _, a in rows]),
    )


def compare_torques(gains: Gains | None = None) -> list[TorqueComparison]:
    """Peak torques of the z motion with the manufacturers' and the identified values."""
    found = []
    for f in (0.4, 5.0, 10.0):
        peaks = []
        for axis in (MANUFACTURER, IDENTIFIED):
            t, *_, torque = simulate("z", f, axis, gains or Gains(), table=True)
            steady = torque[t >= t[-1] - 1.0 / f, 0]
            peaks.append(0.5 * float(np.ptp(steady)))
        found.append(TorqueComparison(frequency=f, manufacturer=peaks[0], identified=peaks[1]))
    return found


def posture_spread() -> float:
    """Largest change of the table's inertia over the motions, relative to what the motors carry in all."""
    home = axes(IDENTIFIED, table=True)
    total = np.linalg.inv(home.inertia_inverse)
    largest = 0.0
    for index, size in MOTIONS.values():
        for sign in (-1.0, 1.0):
            x = HOME + sign * size * np.eye(3)[index]
            at = prs.dynamics(prs.inverse(x, mast.MAST), np.zeros(3), mast.MAST, x)
            axis = IDENTIFIED
            moved = (axis.driving + axis.driven) * np.eye(3) + axis.per_motor**2 * at.inertia
            largest = max(largest, float(np.abs(moved - total).max() / np.abs(total).max()))
    return largest


def _fundamental(signal: Array, t: Array, frequency: float) -> complex:
    """Complex amplitude of a sine by least squares, beside a constant."""
    w = 2.0 * np.pi * frequency * t
    basis = np.column_stack([np.sin(w), np.cos(w), np.ones_like(t)])
    a, b, _ = np.linalg.lstsq(basis, signal, rcond=None)[0]
    return complex(a, b)


def _crossing(frequencies: Array, values: Array, level: float) -> float:
    below = np.flatnonzero(values < level)
    if below.size == 0 or below[0] == 0:
        return float("nan")
    i = below[0]
    share = (level - values[i - 1]) / (values[i] - values[i - 1])
    return float(
        np.exp(np.log(frequencies[i - 1]) * (1.0 - share) + np.log(frequencies[i]) * share)
    )
