"""Is the log itself at fault? Encoder resolution, home offset, and what the controller must have seen.

The stated control law links reference, position and command without any model of the machine. Where
the replayed command differs from the logged one, the log is not what the controller saw: a clock
offset of the positions or of the reference, a scale or an offset of a logged position. Each is fitted
to the replay, the best one is believed when it removes most of the difference, and the runs are
corrected before the machine is diagnosed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from .clock import replay
from .fitting import fit
from .floor import white_noise
from .hypothesis import Hypothesis
from .machine import Array, Machine, RunData
from .prediction import Predictor

LARGEST_SHIFT = 8.0  # samples
FAITHFUL = 0.01  # replay difference, relative to the rms command, that needs no explanation
LEAST_GAIN = 0.5  # fall of the log rms replay difference worth a finding
LARGEST_LEFT = 0.5  # of the replay difference that may stay after a finding, as a share
HOME_COUNTS = 3.0  # encoder steps that the first reading may be away from the reference
HOME_NOISE = 5.0  # standard deviations of the reading's noise that it may be away
STAYS = 0.5  # share of the first reading's distance that is still there on average: a sag
COARSER = 1.5  # ratio of the encoder step found to the stated one
EDGE = 60  # samples at the ends that do not count: filters settle, shifts lack data


@dataclass(frozen=True, kw_only=True)
class SignalFinding:
    """Something wrong with a signal rather than with the machine."""

    effect: str
    form: str
    where: dict[str, Any]
    parameters: dict[str, dict[str, Any]]
    evidence: str
    before: float  # rms replay difference, relative to the rms command
    after: float


@dataclass(frozen=True, kw_only=True)
class _Candidate:
    effect: str
    form: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    scale: Array

    def correct(self, run: RunData, x: Array) -> RunData:
        """The run as the controller saw it, at the parameters ``x`` in units of ``scale``."""
        value = self.scale * x
        n = run.position.shape[1]
        if self.form == "positions late":
            moved = _advanced(run.position, value[0], run.t)
            return replace(run, position=moved, shifted=value[0] / run.dt)
        if self.form == "reference early":
            return replace(
                run,
                reference=_advanced(run.reference, -value[0], run.t),
                reference_rate=_advanced(run.reference_rate, -value[0], run.t),
                reference_acceleration=_advanced(run.reference_acceleration, -value[0], run.t),
            )
        if self.form == "offset in the log":
            return replace(run, position=np.ascontiguousarray(run.position - value[:n]))
        return replace(run, position=np.ascontiguousarray(run.position / (1.0 + value[:n])))


class _Corrected(NamedTuple):
    """A candidate at its best parameters."""

    candidate: _Candidate
    x: Array  # in units of the candidate's scale
    after: float  # rms replay difference [effort unit]


def examine(
    machine: Machine, runs: Sequence[RunData], stated_lsb: float | None
) -> tuple[list[RunData], list[SignalFinding]]:
    """Corrected runs and what was found; only fit runs decide, all runs are corrected.

    ``stated_lsb`` is the encoder step that the log set states [position unit], if any.
    """
    findings = _resolution(runs, stated_lsb, machine)
    fit_runs = [run for run in runs if run.use == "fit"]
    home = _home_offset(machine, fit_runs)
    before = _difference(fit_runs)
    size = float(np.sqrt(np.mean(np.concatenate([r.command for r in fit_runs]) ** 2)))
    if before < FAITHFUL * size:
        return list(runs), findings + home
    candidates = _candidates(machine, runs[0].dt, stated_lsb or runs[0].lsb or 1e-6)
    fitted = [_Corrected(c, *_fit(c, fit_runs)) for c in candidates]
    enough = min(LARGEST_LEFT, float(np.exp(-LEAST_GAIN))) * before
    fitted = [f for f in fitted if f.after < enough]
    if not fitted:
        return list(runs), findings + home
    best = min(fitted, key=lambda f: np.log(f.after) + 0.02 * len(f.candidate.names))
    clocks = [f for f in fitted if f.candidate.effect == "sensor.timing"]
    if best in clocks:  # the controller's law hardly tells which signal is late, the machine does
        best = min(clocks, key=lambda f: _predicted(machine, fit_runs, f))
    candidate, x, after = best
    findings.append(
        SignalFinding(
            effect=candidate.effect,
            form=candidate.form,
            where={"joints": _places(candidate, x, machine)},
            parameters={
                name: {"value": float(v), "unit": unit}
                for name, unit, v in zip(candidate.names, candidate.units, candidate.scale * x)
            },
            evidence=f"the stated controller reproduces the logged command to "
            f"{100 * after / size:.2f} % of its rms with it, to {100 * before / size:.1f} % without",
            before=before / size,
            after=after / size,
        )
    )
    if candidate.form == "offset in the log":
        home = []
    return [candidate.correct(run, x) for run in runs], findings + home


def _candidates(machine: Machine, dt: float, lsb: float) -> list[_Candidate]:
    n = len(machine.joints)
    unit = machine.position_unit
    return [
        _Candidate(
            effect="sensor.timing", form="positions late", names=("late",), units=("s",),
            scale=np.array([dt]),
        ),
        _Candidate(
            effect="sensor.timing", form="reference early", names=("late",), units=("s",),
            scale=np.array([dt]),
        ),
        _Candidate(
            effect="sensor.offset", form="offset in the log",
            names=tuple(f"offset_{s}" for s in machine.joints), units=(unit,) * n,
            scale=np.full(n, 10.0 * lsb),
        ),
        _Candidate(
            effect="sensor.scale", form="scale in the log",
            names=tuple(f"scale_error_{s}" for s in machine.joints), units=("-",) * n,
            scale=np.full(n, 1e-3),
        ),
    ]  # fmt: skip


def _fit(candidate: _Candidate, runs: Sequence[RunData]) -> tuple[Array, float]:
    """Parameters that bring the replay closest to the log, and the rms difference there."""

    def residual(x: Array) -> Array:
        return _replay_errors([candidate.correct(run, x) for run in runs])

    starts = [np.zeros(candidate.scale.size)]
    if candidate.effect == "sensor.timing":
        starts = [np.array([s]) for s in (-3.0, -1.0, 1.0, 3.0)]
        bound = LARGEST_SHIFT
    else:
        bound = np.inf
    start = min(starts, key=lambda x: float(np.sum(residual(x) ** 2)))
    solution = least_squares(residual, start, bounds=(-bound, bound), diff_step=[1e-3], max_nfev=30)
    return solution.x, float(np.sqrt(np.mean(residual(solution.x) ** 2)))


def _predicted(machine: Machine, runs: Sequence[RunData], corrected: _Corrected) -> float:
    """Prediction error of the retuned nominal model on the corrected runs [position unit]."""
    seen = [corrected.candidate.correct(run, corrected.x) for run in runs]
    return fit(Predictor(machine, seen), Hypothesis()).rms


def _difference(runs: Sequence[RunData]) -> float:
    return float(np.sqrt(np.mean(_replay_errors(runs) ** 2)))


def _replay_errors(runs: Sequence[RunData]) -> Array:
    return np.concatenate([(replay(run) - run.command)[EDGE:-EDGE].ravel() for run in runs])


def _advanced(signal: Array, shift: float, t: Array) -> Array:
    """The signal ``shift`` seconds earlier, by linear interpolation; its ends are held."""
    moved = [np.interp(t + shift, t, column) for column in signal.T]
    return np.ascontiguousarray(np.column_stack(moved))


def _places(candidate: _Candidate, x: Array, machine: Machine) -> list[str]:
    if candidate.effect == "sensor.timing":
        return list(machine.joints)
    largest = float(np.max(np.abs(x)))
    return [s for s, v in zip(machine.joints, x) if abs(v) > 0.2 * largest]


def _resolution(
    runs: Sequence[RunData], stated_lsb: float | None, machine: Machine
) -> list[SignalFinding]:
    """A coarser encoder than the log set states."""
    found = float(np.median([run.lsb for run in runs]))
    if not stated_lsb or found < COARSER * stated_lsb:
        return []
    return [
        SignalFinding(
            effect="sensor.quantisation",
            form="encoder step",
            where={"joints": list(machine.joints)},
            parameters={"step": {"value": found, "unit": machine.position_unit}},
            evidence=f"all readings are multiples of {found:.3g} {machine.position_unit}, "
            f"{stated_lsb:.3g} is stated",
            before=found,
            after=found,
        )
    ]


def _home_offset(machine: Machine, runs: Sequence[RunData]) -> list[SignalFinding]:
    """A first reading that is away from the reference by the same amount in every run."""
    first = np.array([run.position[0] - run.reference[0] for run in runs])
    mean, spread = first.mean(axis=0), np.ptp(first, axis=0)
    lsb = max(run.lsb for run in runs)
    noise = np.sqrt(np.mean([np.var(white_noise(run.position), axis=0) for run in runs], axis=0))
    limit = np.maximum(np.maximum(HOME_COUNTS * lsb, HOME_NOISE * noise), 5.0 * spread)
    away = np.abs(mean) > np.maximum(limit, 1e-12)
    # A machine that sags under a load stays away from its reference; one whose readings are off is
    # driven to it.
    later = np.mean([np.mean(run.position - run.reference, axis=0) for run in runs], axis=0)
    away &= np.abs(later) < STAYS * np.abs(mean)
    if lsb <= 0.0 or len(runs) < 2 or not np.any(away):
        return []
    return [
        SignalFinding(
            effect="sensor.offset",
            form="home offset",
            where={"joints": [s for s, a in zip(machine.joints, away) if a]},
            parameters={
                f"offset_{s}": {"value": float(m), "unit": machine.position_unit}
                for s, m, a in zip(machine.joints, mean, away)
                if a
            },
            evidence="every run starts with the same reading away from the reference",
            before=float(np.max(np.abs(mean))),
            after=float(np.max(spread)),
        )
    ]
