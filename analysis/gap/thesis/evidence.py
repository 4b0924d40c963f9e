"""What the printed numbers say without any model: bounds that every linear drive keeps.

Helical motion is half of the translation plus half of the rotation, at the same instants. For a linear
drive whose two sides are alike and a linear controller therefore

1. each collar error in helical motion is half of that in the pure motion;
2. motor torques are half the sum and half the difference of those of the pure motions, so their mean
   RMS is at most sqrt(t^2 + r^2) / 2, with t and r the torques of pure translation and rotation.

A ratio off 1/2, or a torque above the bound, by more than the scatter is dry friction or another
nonlinearity, or a machine that changed between tests.
"""

from dataclasses import dataclass

import numpy as np

from ....models.thesis_tables import CONTROLLERS, E_THETA_RMS, E_U_RMS, TAU_RMS
from .experiment import CROSS_AXIS, METRICS, TESTS, Experiment, Scatter

SIGNIFICANT = 2.0  # standard deviations


@dataclass(frozen=True, kw_only=True)
class Observation:
    """One comparison of printed numbers with what a linear, symmetric drive allows."""

    kind: str  # superposition, torque bound, cross axis or replicate
    rate_Hz: float
    controller: str
    quantity: str
    value: float
    expected: float  # at most this for a torque bound
    deviation: float  # in standard deviations of the scatter
    unit: str

    @property
    def significant(self) -> bool:
        """Whether scatter does not account for it."""
        return self.deviation > SIGNIFICANT


def observations(experiment: Experiment, scatter: Scatter) -> list[Observation]:
    """All comparisons of one table."""
    return [
        *_superposition(experiment, scatter),
        *_torque_bounds(experiment, scatter),
        *_cross_axis(experiment, scatter),
    ]


def _superposition(experiment: Experiment, scatter: Scatter) -> list[Observation]:
    found = []
    for metric, pure in ((E_U_RMS, "translation"), (E_THETA_RMS, "rotation")):
        column = METRICS.index(metric)
        for name in CONTROLLERS:
            helical, alone = (_value(experiment, name, m, metric) for m in ("helical", pure))
            ratio = helical / alone
            sizes = scatter.additive[column] * np.array([1.0 / helical, 1.0 / alone])
            spread = ratio * np.sqrt(2.0 * scatter.relative**2 + np.sum(sizes**2))
            found.append(
                Observation(
                    kind="superposition",
                    rate_Hz=experiment.rate,
                    controller=name,
                    quantity=f"{metric}, helical / {pure}",
                    value=ratio,
                    expected=0.5,
                    deviation=float(abs(ratio - 0.5) / spread),
                    unit="-",
                )
            )
    return found


def _torque_bounds(experiment: Experiment, scatter: Scatter) -> list[Observation]:
    found = []
    for name in CONTROLLERS:
        t, r, h = (
            _value(experiment, name, m, TAU_RMS) for m in ("translation", "rotation", "helical")
        )
        bound = 0.5 * float(np.hypot(t, r))
        found.append(
            Observation(
                kind="torque bound",
                rate_Hz=experiment.rate,
                controller=name,
                quantity=f"{TAU_RMS}, helical",
                value=h,
                expected=bound,
                deviation=max(float((h / bound - 1.0) / (np.sqrt(2.0) * scatter.relative)), 0.0),
                unit="N m",
            )
        )
    return found


def _cross_axis(experiment: Experiment, scatter: Scatter) -> list[Observation]:
    found = []
    for metric, motion in CROSS_AXIS.items():
        usual = float(scatter.additive[METRICS.index(metric)])
        for name in CONTROLLERS:
            value = _value(experiment, name, motion, metric)
            found.append(
                Observation(
                    kind="cross axis",
                    rate_Hz=experiment.rate,
                    controller=name,
                    quantity=f"{metric}, {motion}",
                    value=value,
                    expected=0.0,
                    deviation=value / usual,
                    unit="mm" if metric == E_U_RMS else "rad",
                )
            )
    return found


def _value(experiment: Experiment, controller: str, motion: str, metric: str) -> float:
    return float(experiment.measured[TESTS.index((controller, motion)), METRICS.index(metric)])
