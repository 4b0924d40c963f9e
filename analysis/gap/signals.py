"""Is the log itself at fault? Encoder resolution, home offset, and what the controller must have seen.

The stated control law links reference, position and command without any model of the machine. Where
the replayed command differs from the logged one, the log is not what the controller saw: a clock
offset of one of the signals, a scale or an offset of the logged positions, a scale of the command
(``log_faults``). Each is fitted to the replay, the best one is believed when it removes most of the
difference, and the runs are corrected before the machine is diagnosed.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import least_squares

from ...models.drive_kernels import LoopController
from .clock import replay
from .effects.two_inertia import FAMILY
from .fitting import fit
from .floor import white_noise
from .growth import with_each
from .hypothesis import Fit, Hypothesis
from .log_faults import OTHER_UNIT, Fault, log_faults
from .machine import Array, Machine, RunData, rms, starts_in_motion
from .prediction import Predictor

FAITHFUL = 0.01  # replay difference, relative to the rms command, that needs no explanation
LEAST_GAIN = 0.5  # fall of the log rms replay difference worth a finding
LARGEST_LEFT = 0.5  # of the replay difference that may stay after a finding, as a share
HOME_COUNTS = 3.0  # encoder steps that the first reading may be away from the reference
HOME_NOISE = 5.0  # standard deviations of the reading's noise that it may be away
STAYS = 0.5  # share of the first reading's distance that is still there on average: a sag
COARSER = 1.5  # ratio of the encoder step found to the stated one
CLOSE = 2.0  # ratio of replay differences that does not tell which clock is off
ALIKE = 1.02  # ratio of errors that does not tell two faults from each other
DRY = "friction.coulomb", "friction.stribeck", "friction.presliding"
GAINS = "kp", "ki", "kd", "kv"  # of the controllers of drives
LARGEST_FACTOR = 5.0  # by which a stated gain may be wrong
HOME = "home offset"
PARKED = (
    1.5  # ratio to the level of dry friction up to which a command holds a machine where it stopped
)
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


class _Fitted(NamedTuple):
    """A fault at its best parameters."""

    fault: Fault
    x: Array  # in units of the fault's scale
    after: float  # rms replay difference [effort unit]


def examine(
    machine: Machine, runs: Sequence[RunData], stated_lsb: float | None
) -> tuple[list[RunData], list[SignalFinding]]:
    """Corrected runs and what was found; only fit runs decide, all runs are corrected.

    ``stated_lsb`` is the encoder step that the log set states [position unit], if any.
    """
    fit_runs = [run for run in runs if run.use == "fit"]
    home = _home_offset(machine, fit_runs)
    best, before = _best_fault(machine, fit_runs, stated_lsb)
    if best is None:
        return list(runs), _resolution(fit_runs, stated_lsb, machine) + home
    fault, x, after = best
    corrected = [fault.correct(run, x) for run in runs]
    findings = _resolution([r for r in corrected if r.use == "fit"], stated_lsb, machine)
    size = rms([run.command[run.window] for run in fit_runs])
    findings.append(
        SignalFinding(
            effect=fault.effect,
            form=fault.form,
            where={"joints": _places(fault, x, machine)},
            parameters={
                name: {"value": float(v), "unit": unit}
                for name, unit, v in zip(fault.names, fault.units, fault.scale * x)
            },
            evidence=f"the stated controller reproduces the logged command to "
            f"{100 * after / size:.2f} % of its rms with it, to {100 * before / size:.1f} % without",
            before=before / size,
            after=after / size,
        )
    )
    return corrected, findings + ([] if fault.form == "offset in the log" else home)


def _best_fault(
    machine: Machine, runs: Sequence[RunData], stated_lsb: float | None
) -> tuple[_Fitted | None, float]:
    """The fault of the log that explains the replay, if any does, and the rms replay difference without it.

    A fault that changes what the machine's model sees must help the model as well: where it does not, the log is
    right, and the stated controller is not the one that ran. So it is where other gains explain the command better.
    """
    before = _difference(runs)
    if before < FAITHFUL * rms([run.command[run.window] for run in runs]):
        return None, before
    faults = log_faults(machine, runs, stated_lsb or runs[0].lsb or 1e-6)
    fitted = [_Fitted(fault, *_fit(fault, runs)) for fault in faults]
    enough = min(LARGEST_LEFT, float(np.exp(-LEAST_GAIN))) * before
    as_logged = fit(Predictor(machine, runs), Hypothesis()).rms
    fitted = [
        f
        for f in fitted
        if f.after < enough
        and (f.fault.form != OTHER_UNIT or _is_other_unit(f, runs, stated_lsb))
        and (not f.fault.in_model or _predicted(machine, runs, f) < as_logged)
    ]
    if not fitted:
        return None, before
    best = min(fitted, key=lambda f: np.log(f.after) + 0.02 * len(f.fault.names))
    if _difference_of_free_gains(runs) < best.after / CLOSE:
        return None, before
    units = [f for f in fitted if f.fault.form == OTHER_UNIT]
    clocks = [f for f in fitted if f.fault.effect == "sensor.timing"]
    if units and units[0].after < ALIKE * best.after:  # what a scale of the command does as well
        return units[0], before
    if best in clocks:  # the controller's law hardly tells which signal is late, the machine does
        alike = [f for f in clocks if f.after < CLOSE * best.after]
        best = min(alike, key=lambda f: _predicted(machine, runs, f, len(alike) > 1))
    return best, before


def _difference_of_free_gains(runs: Sequence[RunData]) -> float:
    """Rms replay difference with the best gains of the stated law, infinite for laws that no drive has.

    A wrong gain moves the command as a late signal does: the lag of a position loop is one over its gain.
    """
    if not all(isinstance(run.controller, LoopController) for run in runs):
        return float(np.inf)
    names = [n for n in GAINS if any(np.any(getattr(run.controller, n)) for run in runs)]

    def residual(x: Array) -> Array:
        factors = dict(zip(names, np.exp(x)))
        return _replay_errors(
            [
                replace(
                    run,
                    controller=run.controller._replace(
                        **{n: getattr(run.controller, n) * factor for n, factor in factors.items()}
                    ),
                )
                for run in runs
            ]
        )

    reach = np.log(LARGEST_FACTOR)
    solution = least_squares(
        residual, np.zeros(len(names)), bounds=(-reach, reach), diff_step=[1e-3], max_nfev=30
    )
    return float(np.sqrt(np.mean(residual(solution.x) ** 2)))


def _is_other_unit(fitted: _Fitted, runs: Sequence[RunData], stated_lsb: float | None) -> bool:
    """Whether the factor is that of a unit, and makes the encoder's step the stated one where that is known."""
    if not fitted.fault.is_unit(fitted.x):
        return False
    step = fitted.fault.correct(runs[0], fitted.x).lsb
    return not stated_lsb or step < COARSER * stated_lsb


def _fit(fault: Fault, runs: Sequence[RunData]) -> tuple[Array, float]:
    """Parameters that bring the replay closest to the log, and the rms difference there."""

    def residual(x: Array) -> Array:
        return _replay_errors([fault.correct(run, x) for run in runs])

    start = min(fault.starts, key=lambda x: float(np.sum(residual(x) ** 2)))
    solution = least_squares(
        residual, start, bounds=(-fault.bound, fault.bound), diff_step=[1e-3], max_nfev=30
    )
    return solution.x, float(np.sqrt(np.mean(residual(solution.x) ** 2)))


def _predicted(
    machine: Machine, runs: Sequence[RunData], fitted: _Fitted, with_effect: bool = False
) -> float:
    """Prediction error of the retuned nominal model on the corrected runs [position unit].

    ``with_effect`` adds the one effect that predicts them best: beside what an effect does, a clock may not show.
    """
    seen = [fitted.fault.correct(run, fitted.x) for run in runs]
    predictor = Predictor(machine, seen)
    retuned = fit(predictor, Hypothesis())
    if not with_effect:
        return retuned.rms
    plain = [f for f in machine.forms(seen) if not (f.refined or f.shifts or f.family == FAMILY)]
    return min(f.rms for f in [retuned, *with_each(predictor, retuned, plain, lambda text: None)])


def _difference(runs: Sequence[RunData]) -> float:
    return float(np.sqrt(np.mean(_replay_errors(runs) ** 2)))


def _replay_errors(runs: Sequence[RunData]) -> Array:
    errors = [(replay(run) - run.command)[run.window] for run in runs]
    return np.concatenate([error[EDGE:-EDGE].ravel() for error in errors])


def _places(fault: Fault, x: Array, machine: Machine) -> list[str]:
    if x.size == 1:
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
    """A first reading that is away from the reference by the same amount in every run that starts from rest."""
    runs = [run for run in runs if not starts_in_motion(run)]
    if len(runs) < 2:
        return []
    first = np.array([run.position[0] - run.reference[0] for run in runs])
    mean, spread = first.mean(axis=0), np.ptp(first, axis=0)
    lsb = max(run.lsb for run in runs)
    seen = [(run.position[run.window], run.reference[run.window]) for run in runs]
    noise = np.sqrt(np.mean([np.var(white_noise(q), axis=0) for q, _ in seen], axis=0))
    limit = np.maximum(np.maximum(HOME_COUNTS * lsb, HOME_NOISE * noise), 5.0 * spread)
    away = np.abs(mean) > np.maximum(limit, 1e-12)
    # A machine that sags under a load stays away from its reference; one whose readings are off is
    # driven to it.
    later = np.mean([np.mean(q - wanted, axis=0) for q, wanted in seen], axis=0)
    away &= np.abs(later) < STAYS * np.abs(mean)
    if lsb <= 0.0 or not np.any(away):
        return []
    return [
        SignalFinding(
            effect="sensor.offset",
            form=HOME,
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


def parked(runs: Sequence[RunData], found: Fit) -> bool:
    """Whether dry friction of a hypothesis holds the machine against the command that every run starts with.

    A machine that stopped short of its reference starts there again: its first reading says nothing of the encoder.
    """
    levels = [
        v for (effect, name), v in found.by_key().items() if effect in DRY and "level" in name
    ]
    first = max(float(np.max(np.abs(run.command[0]))) for run in runs)
    return bool(levels) and first < PARKED * max(levels)
