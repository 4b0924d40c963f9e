"""The printed experiment as numbers to fit: tests by metrics, and how well they can be known.

A test is one controller on one motion; its three metrics are RMS of torque, translation error and
rotation error (Friedlaender 2015, Tables 5-4 and 5-9). The thesis prints no scatter, so it is
estimated from the table itself, in two parts:

1. relative: in pure translation PD and TS are one and the same control law (both gains 45 N m/rad and
   0.1 N m s/rad, Table 5-1; the printed simulation agrees to the last digit). What their measured
   values differ by, over sqrt(2), is the scatter between tests;
2. additive: rotation errors in pure translation and translation errors in pure rotation are zero in
   theory. Their median over the controllers is what couples in from elsewhere.
"""

from dataclasses import dataclass

import numpy as np

from ....models import c_drive, thesis_tables
from ....models.benchmark import LSB
from ....models.c_drive import CDriveParameters
from ....models.thesis_tables import CONTROLLERS, E_THETA_RMS, E_U_RMS, MOTIONS, TAU_RMS
from ..machine import Array

METRICS = (TAU_RMS, E_U_RMS, E_THETA_RMS)
TESTS = tuple((controller, motion) for controller in CONTROLLERS for motion in MOTIONS)
CROSS_AXIS = {E_U_RMS: "rotation", E_THETA_RMS: "translation"}  # metric -> motion without it


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """Printed RMS values (tests, metrics) at one rate; nan where the simulation is not printed."""

    rate: float  # cycles per second [Hz]
    measured: Array  # (9, 3) N m, mm, rad
    simulated: Array  # (9, 3) by the thesis


@dataclass(frozen=True, kw_only=True)
class Scatter:
    """How far a printed value may be from what a second test would have given."""

    relative: float  # standard deviation of a value over the value
    additive: Array  # (3,) standard deviation by metric, N m, mm, rad

    def scale(self, measured: Array) -> Array:
        """Sizes that make errors relative: ``relative`` times these are standard deviations."""
        return np.sqrt(measured**2 + (self.additive / self.relative) ** 2)

    def relative_error(self, model: Array, measured: Array) -> Array:
        """Errors of a model in units of the measured values; scatter alone gives rms ``relative``."""
        return (model - measured) / self.scale(measured)


def read_experiment(rate: float) -> Experiment:
    """Table 5-4 at 2 Hz or 5-9 at 1 Hz; ValueError for any other rate."""
    rows = {row.key: row for row in thesis_tables.rms_rows(rate)}
    keys = [(controller, motion, metric) for controller, motion in TESTS for metric in METRICS]
    measured = [rows[key].thesis_exp for key in keys]
    simulated = [rows[key].thesis_sim for key in keys]
    shape = len(TESTS), len(METRICS)
    return Experiment(
        rate=rate,
        measured=np.array(measured, dtype=float).reshape(shape),
        simulated=np.array(simulated, dtype=float).reshape(shape),
    )


def scatter(experiment: Experiment) -> Scatter:
    """Scatter of a table, from its replicate and from what theory says is zero."""
    additive = np.full(len(METRICS), thesis_tables.HALF_PRINT)
    for metric, motion in CROSS_AXIS.items():
        rows = [i for i, test in enumerate(TESTS) if test[1] == motion]
        column = METRICS.index(metric)
        additive[column] = float(np.median(experiment.measured[rows, column]))
    return Scatter(relative=repeatability(experiment), additive=additive)


def repeatability(experiment: Experiment) -> float:
    """Relative standard deviation between tests, from PD and TS in pure translation."""
    differences = replicate_differences(experiment)
    return float(np.sqrt(np.mean(differences**2) / 2.0))


def replicate_differences(experiment: Experiment) -> Array:
    """Log ratios (torque, translation error) of PD and TS in pure translation, one law run twice."""
    pd, ts = (TESTS.index((name, "translation")) for name in ("pd", "ts"))
    columns = [METRICS.index(TAU_RMS), METRICS.index(E_U_RMS)]
    return np.asarray(np.log(experiment.measured[pd, columns] / experiment.measured[ts, columns]))


def quantisation() -> Array:
    """RMS (3,) that the encoders' rounding adds to each metric, uncorrelated with the motion."""
    to_collar = c_drive.collar_pose(np.eye(2), CDriveParameters().lead).T  # (pose, motor)
    u, theta = LSB / np.sqrt(12.0) * np.linalg.norm(to_collar, axis=1)
    return np.array([0.0, 1e3 * u, theta])
