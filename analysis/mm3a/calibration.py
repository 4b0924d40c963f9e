"""``gapscope calibrate mm3a``: both estimators and the analysis of variance on one table of runs."""

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...models.mm3a.step_size import PrismaticStep, RotaryStep, StepModel
from ..files import output_folder, write_whole
from . import anova, likelihood, routine
from .runs import Run, groups


@dataclass(frozen=True, kw_only=True)
class Calibration:
    """What a table of runs says; ``routine`` has a reason where chapter 6 cannot be followed."""

    runs: Sequence[Run]
    likelihood: dict[tuple[int, int], likelihood.Estimate]
    routine: dict[tuple[int, int], PrismaticStep | RotaryStep | str]
    effects: Sequence[anova.Effect]

    def model(self) -> StepModel:
        """Step model with the likelihood parameters; joints not measured keep the printed defaults."""
        steps: dict[str, Any] = {
            field_of(joint, direction): estimate.step()
            for (joint, direction), estimate in self.likelihood.items()
        }
        return StepModel(**steps)


def field_of(joint: int, direction: int) -> str:
    """Name of a joint and direction in ``StepModel``."""
    return f"joint_{joint}_{'positive' if direction > 0 else 'negative'}"


def calibrate(runs: Sequence[Run], method: str = "iteration") -> Calibration:
    """Calibrate every joint and direction that ``runs`` contain.

    The routine, which knows no days, gets the runs of the first day, to which likelihood refers too. ``method`` is that of the routine for d: iteration, printed or exact. InputError where the runs leave
    a parameter undetermined.
    """
    estimates, by_routine = {}, {}
    for joint, direction in groups(runs):
        estimates[joint, direction] = likelihood.estimate(runs, joint, direction)
        by_routine[joint, direction] = _by_routine(runs, joint, direction, method)
    return Calibration(
        runs=runs,
        likelihood=estimates,
        routine=by_routine,
        effects=anova.effects(runs),
    )


def _by_routine(
    runs: Sequence[Run], joint: int, direction: int, method: str
) -> PrismaticStep | RotaryStep | str:
    first_day = min(run.day for run in runs if (run.joint, run.direction) == (joint, direction))
    chosen = [run for run in runs if run.day == first_day]
    try:
        return routine.calibrate_by_routine(chosen, joint, direction, method)
    except ValueError as error:
        return str(error)


def write(calibration: Calibration, out: Path) -> list[Path]:
    """Write ``calibration.json`` and ``calibration.png`` into ``out``; returns the files."""
    from . import plots

    folder = output_folder(out)
    data, figure = folder / "calibration.json", folder / "calibration.png"
    write_whole(data, json.dumps(as_data(calibration), indent=2, allow_nan=False) + "\n")
    plots.save(plots.calibration(calibration), figure)
    return [data, figure]


def as_data(calibration: Calibration) -> dict[str, Any]:
    """The calibration as JSON values, in SI units; null where there is no interval or p-value."""
    return {
        "runs": len(calibration.runs),
        "units": {"joint_1": "rad", "joint_2": "rad", "joint_3": "m", "recoil": "1"},
        "likelihood": {
            field_of(*key): _estimate_data(estimate)
            for key, estimate in calibration.likelihood.items()
        },
        "routine": {
            field_of(*key): {"reason": step} if isinstance(step, str) else asdict(step)
            for key, step in calibration.routine.items()
        },
        "anova": [
            {
                **asdict(effect),
                "statistic": _finite(effect.statistic),
                "p_value": _finite(effect.p_value),
            }
            for effect in calibration.effects
        ],
    }


def _estimate_data(estimate: likelihood.Estimate) -> dict[str, Any]:
    return {
        "parameters": {
            name: {"value": float(value), "half_width_95": _finite(width)}
            for name, value, width in zip(estimate.names, estimate.values, estimate.half_widths)
        },
        "scatter": _finite(estimate.scatter),
        "degrees_of_freedom": estimate.freedom,
        "days": {
            day: {"factor": factor, "half_width_95": _finite(width)}
            for day, (factor, width) in estimate.days.items()
        },
    }


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
