r"""Friction of a servo axis from a velocity profile, by variable projection (Roldan, section 4.1.2).

.. math:: \hat\tau = J_t\ddot\theta + c\,\dot\theta + F_c\tanh(\beta\dot\theta), \qquad
    \min_\beta \|(1 - \Phi(\beta)\Phi(\beta)^+)\,\tau\|^2

(4.11)-(4.14): beta by a search, the linear parameters by least squares inside it. Torque and regressors pass through the
same zero-phase low-pass. Roldan filters the measured signals and takes tanh of the *filtered* rate: near reversals that is
not the filtered friction; ``filter_regressors = False`` does as he does.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.signal import butter, filtfilt

from ...models import friction, servo_kernels
from ...models.servo_axis import ServoAxis
from ...models.servo_kernels import Axes, Loops

Array = NDArray[np.float64]

PERIOD = 7e-3  # of the log [s]
CUTOFF = 3.0  # of the third-order Butterworth filter [Hz]
SLOWEST, FASTEST = 10.0 * np.pi / 30.0, 3700.0 * np.pi / 30.0  # 10 and 3700 rpm [rad/s]
NAMES = ("inertia", "viscous", "coulomb")
PRINTED = {"inertia": 13e-4, "viscous": 1.7e-3, "coulomb": 0.478, "sign_rate": 10.78}  # Table 4.1


@dataclass(frozen=True, kw_only=True)
class Measurement:
    """A run of the profile: arrays (samples,) every ``PERIOD``."""

    rate: Array  # of the motor [rad/s]
    acceleration: Array  # [rad/s^2]
    torque: Array  # [N m]


@dataclass(frozen=True, kw_only=True)
class Identified:
    """Parameters of (4.10) and J_t with standard deviations, by name of ``PRINTED``."""

    values: dict[str, float]
    deviations: dict[str, float]
    rms: float  # of the torque that is left [N m]


def profile() -> Array:
    """Rates of the multiprofile of Fig. 4.4 (samples,) [rad/s]; durations of its parts are not printed."""
    t = np.arange(0.0, 20.0, PERIOD)
    sines = sum(np.sin(2.0 * np.pi * f * t) for f in (0.1, 0.3, 0.5)) / 3.0
    growing = (SLOWEST + (FASTEST - SLOWEST) * t / 20.0) * sines
    levels = np.geomspace(SLOWEST, FASTEST, 6)
    stairs = np.repeat(np.concatenate([levels, levels[::-1]]), round(1.0 / PERIOD))
    up = np.linspace(0.0, FASTEST, round(3.0 / PERIOD))
    ramps = np.concatenate([up, up[::-1]])
    swell = np.geomspace(SLOWEST, FASTEST, round(3.0 / PERIOD))
    swells = np.concatenate([swell, swell[::-1]])
    parts = [growing, stairs, -stairs, ramps, -ramps, swells, -swells]
    return np.concatenate(parts)


def measure(axis: ServoAxis, noise: float = 0.01, seed: int = 0) -> Measurement:
    """The profile on an axis without a machine, under its velocity loop; torque noise in N m.

    Logged are means over ``PERIOD``: instants would alias the transients of the stairs.
    """
    wanted = profile()
    ratio = 28
    loops = Loops(0.0, 1.0, 0.0, 0.14, 11.45, np.inf, PERIOD / ratio, ratio)
    plant = Axes(
        np.array([[1.0 / axis.inertia]]), np.zeros(1), axis.viscous, axis.coulomb, axis.sign_rate,
        axis.torque_constant,
    )  # fmt: skip
    angle, torque = np.empty((ratio * wanted.size, 1)), np.empty((ratio * wanted.size, 1))
    rates = np.ascontiguousarray(wanted[:, None])
    servo_kernels.simulate(np.zeros_like(rates), rates, plant, loops, 4, angle, torque)
    fine = np.gradient(angle[:, 0], PERIOD / ratio)
    mean = fine.reshape(-1, ratio).mean(axis=1)
    ends = np.append(fine[::ratio], fine[-1])
    rng = np.random.default_rng(seed)
    logged = torque.reshape(-1, ratio).mean(axis=1) + noise * rng.normal(size=wanted.size)
    return Measurement(rate=mean, acceleration=np.diff(ends) / PERIOD, torque=logged)


def identify(data: Measurement, *, filter_regressors: bool = True) -> Identified:
    """J_t, c, F_c and beta from one measurement."""
    b, a = butter(3, CUTOFF, fs=1.0 / PERIOD)

    def low(signal: Array) -> Array:
        return np.asarray(filtfilt(b, a, signal, axis=0))

    torque = low(data.torque)
    rate, acceleration = data.rate, data.acceleration
    if not filter_regressors:
        rate, acceleration = low(rate), low(acceleration)

    def matrix(sign_rate: float) -> Array:
        sign = friction.sech_dry(rate, 0.0, 1.0, 0.0, 0.0, sign_rate)
        columns = np.column_stack([acceleration, rate, sign])
        return low(columns) if filter_regressors else columns

    def left(x: Array) -> Array:
        phi = matrix(float(np.exp(x[0])))
        return np.asarray(torque - phi @ np.linalg.lstsq(phi, torque, rcond=None)[0])

    starts = np.log([0.3, 3.0, 30.0])
    found = min(
        (least_squares(left, [s], bounds=(np.log(0.01), np.log(1e3))) for s in starts),
        key=lambda solution: float(solution.cost),
    )
    beta = float(np.exp(found.x[0]))
    phi = matrix(beta)
    linear = np.linalg.lstsq(phi, torque, rcond=None)[0]
    step = 1e-4
    slope = (matrix(beta * (1 + step)) - matrix(beta * (1 - step))) @ linear / (2.0 * step * beta)
    full = np.column_stack([phi, slope])
    # What the filter leaves is correlated: as many independent samples as its band holds.
    independent = torque.size * 2.0 * CUTOFF * PERIOD
    variance = float(np.sum(left(found.x) ** 2)) / torque.size
    covariance = np.linalg.inv(full.T @ full) * variance * torque.size / independent
    names = (*NAMES, "sign_rate")
    values = dict(zip(names, [*map(float, linear), beta]))
    deviations = dict(zip(names, map(float, np.sqrt(np.diag(covariance)))))
    return Identified(values=values, deviations=deviations, rms=float(np.sqrt(variance)))
