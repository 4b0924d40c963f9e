"""Measured forces and motion of a machine: an independent plant, friction, encoders, noise, and the filters.

The plant is the chain of bodies and closures as a MultibodyPlant: it shares no equation with the regressor. Rigid
forces of a periodic motion are smooth; they are taken at a few hundred instants of a cycle and interpolated by
their Fourier series. Friction is the exact sgn(v) and v.
"""

from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
import scipy.ndimage
import scipy.signal
from numpy.typing import NDArray

from ...models.friction import viscous
from ...systems.closed_chain import ClosedChain
from .machine import Machine

Floats = NDArray[np.float64]

INSTANTS = 400  # of a cycle at which the plant is asked
CYCLES = 4
SETTLED = 3.0  # periods of the cutoff after which a filter has forgotten its start
STENCIL = (
    np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0]) / 60.0
)  # derivative, error of sixth order
LAGS = 16  # rows apart at which filtered noise is taken as independent
DOUBT = 1e-3  # largest weight in a filtered row of samples whose direction of motion is not seen


class Periodic(Protocol):
    """A motion whose cycles repeat."""

    @property
    def period(self) -> float:
        """Of one cycle [s]."""

    def sample(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Positions, rates and accelerations (times, n)."""


@dataclass(frozen=True)
class Sinusoid:
    """All axes along one sine about ``start``."""

    start: Floats  # (n,)
    amplitude: float
    frequency: float  # [Hz]

    @property
    def period(self) -> float:
        """Of one cycle [s]."""
        return 1.0 / self.frequency

    def sample(self, t: Floats) -> tuple[Floats, Floats, Floats]:
        """Positions, rates and accelerations (times, n)."""
        w = 2.0 * np.pi * self.frequency
        sine, cosine = np.sin(w * t)[:, None], np.cos(w * t)[:, None]
        one = self.amplitude * np.ones_like(self.start)
        return self.start + sine * one, w * cosine * one, -w * w * sine * one


class Ideal(NamedTuple):
    """What happens, without sensors: (times, n)."""

    position: Floats
    force: Floats


class Regression(NamedTuple):
    """Filtered and decimated rows of W parameters = force."""

    regressor: Floats  # (rows, parameters), axis by axis at each instant
    force: Floats  # (rows,)
    axis: NDArray[np.int64]  # (rows,)
    time: Floats  # (rows,) [s]
    spacing: float = 1.0  # of rows of an axis [s]; where rows are left out, a multiple of it
    correlation: Floats = np.ones(1)  # of white noise behind the filter, 0, 1, .. spacings apart


def ideal(machine: Machine, rigid: Floats, motion: Periodic) -> Ideal:
    """Motion and forces over CYCLES cycles, from the plant with rigid parameters (p,)."""
    plant = ClosedChain(machine.chain(rigid))
    count = round(CYCLES * motion.period / machine.period)
    # A cycle is rarely a whole number of samples; the Fourier series is evaluated where the samples are.
    t = np.asarray(machine.period * np.arange(count), dtype=float)
    few = np.asarray(np.arange(INSTANTS) / INSTANTS * motion.period, dtype=float)
    forces, near = [], None
    for q, v, a in zip(*motion.sample(few)):
        near = plant.close(q, near)
        at = plant.project(near, v)
        forces.append(at.matrix @ a + at.bias)
    q, v, _ = motion.sample(t)
    smooth = _fourier(np.array(forces), t / motion.period)
    dry = machine.coulomb * np.sign(v) + viscous(v, machine.viscous)
    return Ideal(q, smooth + dry)


def measure(machine: Machine, what: Ideal, seed: int) -> Regression:
    """Quantised positions and noisy forces, differentiated, filtered without phase, decimated.

    The same filter is run over every column of W and the forces, so that it biases nothing. That of the positions is
    flatter, and their derivatives of sixth order: plain central differences take 0.1 % off a sine of 4 Hz sampled
    at 2 ms. At rest the encoder does not show the sign of the speed, and so of dry friction: rows of an axis that
    hold such samples are left out.
    """
    rng = np.random.default_rng(seed)
    step, dt = machine.resolution, machine.period
    counted = step * np.floor(what.position / step + rng.uniform(size=machine.axes))
    force = what.force + machine.noise * rng.normal(size=what.force.shape)
    low, flat = (
        scipy.signal.butter(order, machine.cutoff, fs=1.0 / dt, output="sos") for order in (3, 4)
    )
    q = scipy.signal.sosfiltfilt(flat, counted, axis=0)
    v = _derivative(q, dt)
    a = _derivative(v, dt)
    rows = machine.full_regressor(q, v, a)
    rows = scipy.signal.sosfiltfilt(low, rows, axis=0)
    force = scipy.signal.sosfiltfilt(low, force, axis=0)
    # Two rows a period of the cutoff, without the edges.
    each = max(1, round(0.5 / (machine.cutoff * dt)))
    edge = round(SETTLED / (machine.cutoff * dt))
    kept = slice(edge, -edge, each)
    clear = ~_doubtful(machine, v, low)[kept]
    axis, time = np.meshgrid(np.arange(machine.axes), dt * np.arange(len(q))[kept])
    return Regression(
        rows[kept][clear],
        force[kept][clear],
        axis[clear],
        time[clear],
        each * dt,
        noise_correlation(low, each),
    )


def _derivative(values: Floats, dt: float) -> Floats:
    """Of samples (times, n); the three at each end are of no use."""
    return np.asarray(
        scipy.ndimage.correlate1d(values, STENCIL / dt, axis=0, mode="nearest"), dtype=float
    )


def noise_correlation(low: Floats, each: int) -> Floats:
    """Of white noise filtered forwards and backwards (LAGS,), at multiples of ``each`` samples."""
    reach = 2 * LAGS * each
    impulse = np.zeros(2 * reach + 1)
    impulse[reach] = 1.0
    answer = scipy.signal.sosfiltfilt(low, impulse, padtype=None)
    power = scipy.signal.correlate(answer, answer)[answer.size - 1 :]
    return np.asarray(power[: LAGS * each : each] / power[0])


def _doubtful(machine: Machine, v: Floats, low: Floats) -> NDArray[np.bool_]:
    """Whether rows (times, n) rest on samples slower than one encoder step at the filter's cutoff."""
    slowest = 2.0 * np.pi * machine.cutoff * machine.resolution
    still = (np.abs(v) < slowest).astype(float)
    return np.asarray(np.abs(scipy.signal.sosfiltfilt(low, still, axis=0)) > DOUBT)


def _fourier(values: Floats, phase: Floats) -> Floats:
    """Periodic series (phases, n) through values (instants, n) of one cycle at equal distances."""
    spectrum = np.fft.rfft(values, axis=0) / len(values)
    keep = len(values) // 2  # the highest order is ambiguous, and empty for smooth forces
    order = np.arange(1, keep)
    wave = np.exp(2j * np.pi * np.outer(phase, order))
    return np.asarray(spectrum[0].real + 2.0 * (wave @ spectrum[1:keep]).real)
