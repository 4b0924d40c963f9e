"""``gapscope compare mm3a``: prediction and positioning errors of the step models, written to a folder."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..files import output_folder, write_whole
from . import experiments, positioning, prediction
from .calibration import field_of
from .experiments import Environment


@dataclass(frozen=True, kw_only=True)
class Report:
    """Everything the command shows."""

    truth: str  # empirical or physical
    comparison: prediction.Comparison
    growth: positioning.ErrorGrowth  # against the printed step model as truth


def report(truth: str, seed: int) -> Report:
    """Compare the models on a simulated day. InputError for an unknown truth.

    Positioning is judged against the printed step model, calibrated from its own simulated runs.
    """
    environment = Environment()
    chosen = prediction.compare(experiments.truth_named(truth), environment=environment, seed=seed)
    printed = (
        chosen
        if truth == "empirical"
        else prediction.compare(
            experiments.truth_named("empirical"), environment=environment, seed=seed
        )
    )
    conditions = positioning.Conditions(
        scale=tuple(map(tuple, experiments.day_factors(environment, np.random.default_rng(seed))))
    )
    return Report(
        truth=truth,
        comparison=chosen,
        growth=positioning.error_growth(printed.models, conditions=conditions, seed=seed),
    )


def write(result: Report, out: Path) -> list[Path]:
    """Write ``comparison.json`` and the figures into ``out``; returns the files."""
    from ...diagrams.mm3a_view import replay_page
    from . import plots, square

    folder = output_folder(out)
    data = folder / "comparison.json"
    write_whole(data, json.dumps(as_data(result), indent=2, allow_nan=False) + "\n")
    drawing = square.draw_square()
    figures = {
        "prediction": plots.prediction(result.comparison),
        "positioning": plots.positioning(result.growth),
        "prismatic-steps": plots.prismatic_steps(),
        "rotary-steps": plots.rotary_steps(),
        "travel": plots.travel(),
        "actuator-trends": plots.actuator_trends(),
        "equation-6-6": plots.load_from_difference(),
        "view": plots.view(drawing),
    }
    files = [data]
    for name, canvas in figures.items():
        files.append(folder / f"{name}.png")
        plots.save(canvas, files[-1])
    files.append(folder / "view.html")
    write_whole(files[-1], replay_page(drawing.joints["step model"], drawing.wanted))
    return files


def as_data(result: Report) -> dict[str, Any]:
    """The comparison as JSON values: relative errors, and tip errors in m."""
    return {
        "truth": result.truth,
        "prediction": {
            field_of(p.joint, p.direction): {
                name: {"rms": p.rms(name), "worst": p.worst(name)} for name in p.errors
            }
            for p in result.comparison.predictions
        },
        "positioning": {
            "distance_m": list(result.growth.distances),
            "rms_error_m": {
                name: [float(e) for e in result.growth.rms(name)] for name in result.growth.errors
            },
        },
    }
