"""Which setting reproduces the errors of computed torque that the thesis prints of its simulation?

Friedlaender 2015, Table 5-4: CT errs by 0.1811 mm in translation, 0.0012 rad in rotation, and 0.0936 mm
and 0.0003 rad in helical motion. A sampled loop with the printed gains gives about 60 % of that. A
setting explains the table only if it meets all of its non-zero values, of all three controllers.

Three kinds of evidence, from the printed numbers alone towards the simulation:

1. a bound: a linear PD law has |K_P + K_D F(jw)| >= K_P, so its RMS torque is at least K_P times the RMS
   of the error it acts on; what a printed error exceeds tau/K_P by, the law did not see;
2. a fit of damping and dead zone to the PD and TS rows only, which predicts CT;
3. the variants of ``ct_error_variants.py``, one change each.
"""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from ..models import thesis_tables
from ..models.benchmark import LSB, SETTINGS
from ..models.c_drive import CDriveParameters
from ..models.c_drive_controllers import TaskSpacePD
from ..models.thesis_tables import HALF_PRINT, Key
from .ct_error_variants import BASE, Metrics, block_metrics, variants
from .files import output_folder, write_whole

TOLERANCE = 0.02  # of each printed RMS, beside half a unit of print
TARGETS: dict[Key, float] = {
    row.key: row.thesis_sim for row in thesis_tables.rms_rows(2.0) if row.thesis_sim
}
OTHER_TABLES: dict[Key, float] = {
    row.key: row.thesis_sim
    for row in (*thesis_tables.endpoint_rows(), *thesis_tables.maximum_rows())
    if row.controller == "ct" and row.thesis_sim
}
CT_ERRORS: tuple[Key, ...] = tuple(
    key for key in TARGETS if key[0] == "ct" and key[2] != thesis_tables.TAU_RMS
)


@dataclass(frozen=True, kw_only=True)
class Trial:
    """One variant against the printed simulation."""

    group: str
    label: str
    values: dict[str, float]  # by "controller motion metric"
    matched: int  # RMS values within tolerance, of ``len(TARGETS)``
    matched_elsewhere: int  # of the CT values in ``OTHER_TABLES``
    worst_other: float  # largest relative deviation of a PD or TS RMS
    worst_ct_torque: float  # largest relative deviation of a CT torque RMS
    reproduces: bool  # every RMS value is matched


@dataclass(frozen=True, kw_only=True)
class GainBound:
    """What a printed RMS error exceeds the bound tau/K_P by."""

    source: str  # thesis_sim or thesis_exp
    controller: str
    motion: str
    rate_Hz: float
    excess_counts: float  # of the encoder; above zero no linear PD law explains the print
    rounding_counts: float  # half a unit of print in both numbers


@dataclass(frozen=True, kw_only=True)
class DeadZoneFit:
    """Damping and dead zone fitted to PD and TS alone, and what they predict for CT."""

    beta: float  # [N m s/rad]
    gamma: float  # [N m s/rad]
    dead_zone_counts: float  # half width
    rms_deviation: float  # relative, of the 14 fitted values
    predicted: dict[str, tuple[float, float]]  # CT: (ours, printed)


@dataclass(frozen=True, kw_only=True)
class Study:
    """All evidence."""

    bounds: tuple[GainBound, ...]
    fit: DeadZoneFit
    trials: tuple[Trial, ...]
    provenance: dict[str, Any]


def run_study(parameters: CDriveParameters | None = None) -> Study:
    """Run every variant; some ten seconds."""
    parameters = parameters or CDriveParameters()
    return Study(
        bounds=gain_bounds(),
        fit=fit_dead_zone(parameters),
        trials=tuple(
            judge(variant.group, variant.label, variant.simulate())
            for variant in variants(parameters)
        ),
        provenance={
            "program": f"gapscope {version('gapscope')}",
            "source": "Friedlaender 2015, Tables 5-1 to 5-9",
            "parameters": asdict(parameters),
            "tolerance": TOLERANCE,
        },
    )


def judge(group: str, label: str, values: Metrics) -> Trial:
    """Compare one variant's metrics with Table 5-4."""
    deviation = {key: values[key] / printed - 1.0 for key, printed in TARGETS.items()}
    matched = _matched(values, TARGETS)
    return Trial(
        group=group,
        label=label,
        values={" ".join(key): values[key] for key in (*TARGETS, *OTHER_TABLES)},
        matched=matched,
        matched_elsewhere=_matched(values, OTHER_TABLES),
        worst_other=max(abs(d) for key, d in deviation.items() if key[0] != "ct"),
        worst_ct_torque=max(
            abs(d)
            for key, d in deviation.items()
            if key[0] == "ct" and key[2] == thesis_tables.TAU_RMS
        ),
        reproduces=matched == len(TARGETS),
    )


def _matched(values: Metrics, printed: dict[Key, float]) -> int:
    return sum(
        abs(values[key] - number) <= TOLERANCE * abs(number) + HALF_PRINT
        for key, number in printed.items()
    )


def gain_bounds() -> tuple[GainBound, ...]:
    """Evidence 1, for PD and TS in the pure motions, where one gain acts."""
    found = []
    lead = CDriveParameters().lead
    for rate in (2.0, 1.0):
        rows = {row.key: row for row in thesis_tables.rms_rows(rate)}
        for source in ("thesis_sim", "thesis_exp") if rate == 2.0 else ("thesis_exp",):
            for controller in ("pd", "ts"):
                for motion, metric, unit in (
                    ("translation", thesis_tables.E_U_RMS, 1e-3 * 2.0 * np.pi / lead),
                    ("rotation", thesis_tables.E_THETA_RMS, 1.0),
                ):
                    error = unit * getattr(rows[controller, motion, metric], source)
                    torque = getattr(rows[controller, motion, thesis_tables.TAU_RMS], source)
                    gain = _proportional_gain(controller, motion)
                    found.append(
                        GainBound(
                            source=source,
                            controller=controller,
                            motion=motion,
                            rate_Hz=rate,
                            excess_counts=(error - torque / gain) / LSB,
                            rounding_counts=HALF_PRINT * (unit + 1.0 / gain) / LSB,
                        )
                    )
    return tuple(found)


def _proportional_gain(controller: str, motion: str) -> float:
    if controller == "pd":
        return SETTINGS["pd"].kp  # type: ignore[union-attr]
    gains = TaskSpacePD()
    return gains.kp_translation if motion == "translation" else gains.kp_rotation


def fit_dead_zone(parameters: CDriveParameters) -> DeadZoneFit:
    """Evidence 2: least squares over the 14 non-zero RMS values of PD and TS."""
    fitted = [key for key in TARGETS if key[0] != "ct"]
    printed = np.array([TARGETS[key] for key in fitted])
    start = np.array([parameters.beta, parameters.gamma, LSB])

    def simulate(x: Any, /) -> Metrics:
        damped = replace(parameters, beta=x[0] * start[0], gamma=x[1] * start[1])
        return block_metrics(
            replace(BASE, wiring=BASE.wiring._replace(dead_zone=x[2] * start[2])), damped
        )

    def deviations(x: Any, /) -> Any:
        values = simulate(x)
        return np.array([values[key] for key in fitted]) / printed - 1.0

    # The encoder makes the metrics step by about 1e-3: differences over 1 % see through that.
    solution = least_squares(deviations, [1.0, 1.0, 0.5], bounds=(0.0, 3.0), diff_step=[1e-2] * 3)
    best = simulate(solution.x)
    return DeadZoneFit(
        beta=float(solution.x[0] * start[0]),
        gamma=float(solution.x[1] * start[1]),
        dead_zone_counts=float(solution.x[2]),
        rms_deviation=float(np.sqrt(np.mean(solution.fun**2))),
        predicted={
            " ".join(key): (best[key], printed_value)
            for key, printed_value in TARGETS.items()
            if key[0] == "ct"
        },
    )


def write_study(study: Study, folder: Path) -> list[Path]:
    """Write ``ct_errors.json`` and ``ct_errors.md``."""
    folder = output_folder(folder)
    contents = {
        "ct_errors.json": json.dumps(asdict(study), indent=2) + "\n",
        "ct_errors.md": markdown(study),
    }
    for name, content in contents.items():
        write_whole(folder / name, content)
    return [folder / name for name in contents]


def markdown(study: Study) -> str:
    """The study as a document."""
    return "\n".join(
        [
            "# Errors of computed torque in the thesis's simulation",
            "",
            *_verdict(study),
            "",
            "## 1. What the printed PD and TS numbers say by themselves",
            "",
            "A linear PD law never commands less RMS torque than K_P times the RMS error it acts on. Printed error "
            "minus printed torque over K_P, in encoder counts (0.000767 rad); above zero the law "
            "did not see part of the error:",
            "",
            *_bounds_table(study.bounds),
            "",
            "## 2. Damping and dead zone from PD and TS alone",
            "",
            *_fit_lines(study.fit),
            "",
            "## 3. One change at a time",
            "",
            f"Matched: within {100 * TOLERANCE:g} % plus half a unit of print, of {len(TARGETS)} RMS values. The last "
            "columns are from Tables 5-7 and 5-8.",
            "",
            *_trials_table(study.trials),
            "",
        ]
    )


def _verdict(study: Study) -> list[str]:
    found = [trial for trial in study.trials if trial.reproduces]
    total = len(TARGETS)
    if not found:
        return [f"None of the {len(study.trials)} settings meets all {total} RMS values."]
    without = max(
        (trial for trial in study.trials if not has_dead_zone(trial)), key=lambda t: t.matched
    )
    return [
        f"{len(found)} of {len(study.trials)} settings meet all {total} non-zero RMS values of Table 5-4; "
        f"all have a dead zone on the error. Without one the best meets {without.matched} "
        f"({without.group}: {without.label}). The setting used elsewhere: continuous blocks under ODE4, "
        "M and D × 0.95 in the controller's model, a dead zone of one encoder count.",
        "",
        "What the printed values decide, and the settings that survive:",
        "",
        *[
            f"- {group}: {_survivors(study.trials, group)}"
            for group in ("model error", "dead zone", *_friction_groups(study.trials))
        ],
        "",
        "What they leave open: "
        + "; ".join(
            f"{trial.group}: {trial.label}"
            for trial in found
            if trial.group in ("delays and holds", "encoder", "derivative filter", "observer")
        )
        + ".",
        "",
        "Lowest translation error of CT (the thesis: c near 1 in simulation): "
        + "; ".join(
            f"{group}: {_best_gain(study.trials, group)}"
            for group in _friction_groups(study.trials)
        )
        + ".",
        "",
        f"Of the {len(OTHER_TABLES)} non-zero CT values in Tables 5-7 (endpoints) and 5-8 (maxima) no setting "
        f"meets more than {max(trial.matched_elsewhere for trial in study.trials)}; Table 5-8 contradicts "
        "Table 5-4 (models/thesis_tables.py), so it does not decide between settings. The dead zone and "
        "the sign of the model error are inferred, not printed.",
    ]


def _friction_groups(trials: Sequence[Trial]) -> list[str]:
    return list(
        dict.fromkeys(trial.group for trial in trials if trial.group.startswith("friction gain"))
    )


def _survivors(trials: Sequence[Trial], group: str) -> str:
    members = [trial for trial in trials if trial.group == group]
    labels = [trial.label for trial in members if trial.reproduces] or ["none"]
    return f"{', '.join(labels)} (of {len(members)} tried beside the setting above)"


def _best_gain(trials: Sequence[Trial], group: str) -> str:
    key = " ".join(("ct", "translation", thesis_tables.E_U_RMS))
    return min(
        (trial for trial in trials if trial.group == group), key=lambda t: t.values[key]
    ).label


def has_dead_zone(trial: Trial) -> bool:
    """Whether the setting of this trial has a dead zone."""
    return not (
        "no dead zone" in trial.label
        or trial.group in ("sampled loop", "metric")
        or (trial.group, trial.label) == ("dead zone", "0 counts")
    )


def _bounds_table(bounds: Sequence[GainBound]) -> list[str]:
    return [
        "| source | rate [Hz] | controller | motion | excess [counts] |",
        "|---|---|---|---|---|",
        *[
            f"| {b.source} | {b.rate_Hz:g} | {b.controller.upper()} | {b.motion} | "
            f"{b.excess_counts:+.2f} ± {b.rounding_counts:.2f} |"
            for b in bounds
        ],
    ]


def _fit_lines(fit: DeadZoneFit) -> list[str]:
    return [
        f"beta {1e3 * fit.beta:.3f} mN m s/rad, gamma {1e3 * fit.gamma:.3f} mN m s/rad, dead zone "
        f"{fit.dead_zone_counts:.2f} counts; the 14 PD and TS values are met to {100 * fit.rms_deviation:.2f} % "
        "RMS. Not fitted, predicted:",
        "",
        "| CT | predicted | printed | deviation |",
        "|---|---|---|---|",
        *[
            f"| {name.removeprefix('ct ')} | {ours:.5f} | {printed:.4f} | {100 * (ours / printed - 1):+.1f} % |"
            for name, (ours, printed) in fit.predicted.items()
        ],
    ]


def _trials_table(trials: Sequence[Trial]) -> list[str]:
    others = (
        ("ct", "translation", thesis_tables.E_U_END),
        ("ct", "translation", thesis_tables.E_U_MAX),
        ("ct", "translation", thesis_tables.TAU_MAX),
    )
    header = (
        "group",
        "setting",
        "matched",
        "worst PD, TS",
        "worst CT torque",
        *[f"{motion} {metric}" for _, motion, metric in (*CT_ERRORS, *others)],
    )
    printed = [f"{ {**TARGETS, **OTHER_TABLES}[key]:.4f}" for key in (*CT_ERRORS, *others)]
    lines = [
        "| " + " | ".join(header) + " |",
        "|" + "---|" * len(header),
        "| printed | | | | | " + " | ".join(printed) + " |",
    ]
    for trial in trials:
        values = [f"{trial.values[' '.join(key)]:.4f}" for key in (*CT_ERRORS, *others)]
        matched = f"**{trial.matched}**" if trial.reproduces else f"{trial.matched}"
        lines.append(
            f"| {trial.group} | {trial.label} | {matched} | {100 * trial.worst_other:.1f} % | "
            f"{100 * trial.worst_ct_torque:.1f} % | " + " | ".join(values) + " |"
        )
    return lines
