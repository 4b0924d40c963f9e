"""Noise floor: what repeats of the same motion do not repeat.

No model can explain it, so no gap is claimed below it. Where a run repeats its motion, the floor is
the rms difference between its cycles over sqrt(2), after the first cycle, which starts from rest. It
is never below what the encoder's quantisation, lsb / sqrt(12) and white, does to the prediction; that
alone is the floor of runs without repeated cycles, although a machine's own noise exceeds it.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

if TYPE_CHECKING:
    from .machine import RunData

Array = NDArray[np.float64]

NOISE_BAND = 0.4  # share of the Nyquist frequency above which only the encoder's noise is expected
MEASURED = "cycle-to-cycle repeatability"
NO_CYCLES = "the runs hold no repeated cycles"
NOISELESS = 1e-9  # of the travel: a floor of readings without noise
SEGMENT = 256  # samples of a Welch segment


def repeatability(residual: Array, period: int) -> Array | None:
    """What does not repeat in a residual (samples, n) with cycles of ``period`` samples; or None.

    Returned as differences over sqrt(2) whose rms is the floor, two cycles at least are needed.
    """
    cycles = len(residual) // period
    if cycles < 2:
        return None
    stack = residual[: cycles * period].reshape(cycles, period, -1)
    if cycles > 2:
        stack = stack[1:]
    return np.asarray(np.diff(stack, axis=0).reshape(-1, residual.shape[1]) / np.sqrt(2.0))


def quantisation_floor(lsb: float, bandwidth: float, dt: float, shifted: float = 0.0) -> float:
    """Rms prediction error that white quantisation noise alone causes.

    ``shifted`` [samples] is how far linear interpolation has moved the readings.
    """
    length = int(50.0 / (bandwidth * dt)) + 10  # samples after which its response is over
    passed = _noise_filter(np.asarray(np.fft.fftfreq(length, dt), float), bandwidth, dt, shifted)
    return float(lsb / np.sqrt(12.0) * np.sqrt(np.mean(np.abs(passed) ** 2)))


def out_of_step(
    runs: "Sequence[RunData]", residuals: Sequence[Array], bandwidth: float
) -> float | None:
    """How many times what does not repeat exceeds the encoder's noise; None without repeated cycles.

    The noise is white and reaches the prediction error through a known filter, so its size shows above
    ``NOISE_BAND`` of the Nyquist frequency. What exceeds it below is a disturbance that keeps
    another time than the motion: a hum, knocks, lost samples. It raises the floor that gaps are
    measured by.
    """
    seen = noise = 0.0
    for run, residual in zip(runs, residuals):
        repeated = repeatability(residual, run.period) if run.period else None
        if repeated is None:
            continue
        frequency, power = welch(
            repeated, 1.0 / run.dt, nperseg=min(SEGMENT, len(repeated)), axis=0
        )
        passed = np.abs(_noise_filter(frequency, bandwidth, run.dt, run.shifted)) ** 2
        high = frequency > NOISE_BAND * frequency[-1]
        level = power[high].sum() / passed[high].sum()
        seen += float(power.sum())
        noise += float(level * passed.sum())
    return float(np.sqrt(seen / noise)) if noise > 0.0 else None


def over_white_noise(runs: "Sequence[RunData]", residuals: Sequence[Array]) -> float | None:
    """As ``out_of_step``, for a residual whose measurement noise is white and smooth otherwise."""
    repeated = [
        (r, found)
        for run, r in zip(runs, residuals)
        if run.period and (found := repeatability(r, run.period)) is not None
    ]
    if not repeated:
        return None
    noise = np.concatenate([white_noise(r).ravel() for r, _ in repeated])
    seen = np.concatenate([found.ravel() for _, found in repeated])
    level = float(np.sqrt(np.mean(noise**2)))
    return float(np.sqrt(np.mean(seen**2))) / level if level > 0.0 else None


def white_noise(signal: Array) -> Array:
    """What is left of a signal (samples, n) that is smooth but for white noise, as large as that noise.

    Third differences leave little of anything smooth and sqrt(20) times the noise.
    """
    return np.asarray(np.diff(signal, 3, axis=0) / np.sqrt(20.0))


def _noise_filter(frequency: Array, bandwidth: float, dt: float, shifted: float) -> Array:
    """Frequency response from measurement noise to prediction error.

    That of the alpha-beta observer is ((z - 1) / (z - p))^2. Before it comes the interpolation that has moved the
    readings by ``shifted`` samples.
    """
    z = np.exp(2j * np.pi * frequency * dt)
    observer = ((z - 1.0) / (z - np.exp(-bandwidth * dt))) ** 2
    return np.asarray(np.polyval(_interpolation(shifted), z) * observer)


def _interpolation(shifted: float) -> Array:
    """Weights (2,) of the two readings that a linear interpolation by ``shifted`` samples mixes."""
    share = shifted % 1.0
    return np.array([1.0 - share, share])


def repeatability_floor(
    runs: "Sequence[RunData]", residuals: Sequence[Array]
) -> tuple[list[Array], str]:
    """Floor samples (k, n) of every run from repeated cycles alone, zero where there are none."""
    floors = []
    for run, residual in zip(runs, residuals):
        repeated = repeatability(residual, run.period) if run.period else None
        floors.append(np.zeros((1, residual.shape[1])) if repeated is None else repeated)
    if any(run.period for run in runs):
        return floors, MEASURED
    return floors, NO_CYCLES


def noise_floor(
    runs: "Sequence[RunData]", residuals: Sequence[Array], bandwidth: float
) -> tuple[list[Array], str]:
    """Floor samples (k, n) of every run and how they were found.

    ``residuals`` are prediction errors of the runs, of whatever model: what it lacks repeats.
    """
    floors, found = [], set()
    for run, residual in zip(runs, residuals):
        encoder = quantisation_floor(run.lsb, bandwidth, run.dt, run.shifted)
        if encoder == 0.0:  # readings without steps
            encoder = _white_floor(run, residual, bandwidth)
        repeated = repeatability(residual, run.period) if run.period else None
        if repeated is None:
            found.add(f"encoder resolution; {NO_CYCLES}")
            floors.append(encoder * _uncorrelated_signs(residual))
        elif np.sqrt(np.mean(repeated**2)) < encoder:
            found.add("encoder resolution, which exceeds the cycle-to-cycle repeatability")
            floors.append(encoder * _uncorrelated_signs(residual))
        else:
            found.add(MEASURED)
            floors.append(repeated)
    return floors, " and ".join(sorted(found))


def _white_floor(run: "RunData", residual: Array, bandwidth: float) -> float:
    """Rms prediction error that the white noise of the readings causes, whose size shows at high frequencies.

    Never zero: simulated readings may have no noise at all.
    """
    length = min(SEGMENT, len(residual))
    frequency, power = welch(residual, 1.0 / run.dt, nperseg=length, axis=0)
    passed = np.abs(_noise_filter(frequency, bandwidth, run.dt, run.shifted)) ** 2
    high = frequency > NOISE_BAND * frequency[-1]
    level = float(power[high].mean(axis=1).sum() / passed[high].sum())
    size = float(np.sqrt(level * np.sum(passed) * (frequency[1] - frequency[0])))
    return max(size, NOISELESS * float(np.ptp(run.position)))


def _uncorrelated_signs(residual: Array) -> Array:
    """Columns of +-1 (samples, n) that are uncorrelated with each other: noise of known size."""
    k = np.arange(len(residual))[:, None] >> np.arange(residual.shape[1])
    return np.asarray(1.0 - 2.0 * (k % 2), dtype=np.float64)
