"""Tables of the MM3A commands in the terminal."""

from dataclasses import asdict

import numpy as np
from rich.console import Console
from rich.table import Table

from .calibration import Calibration
from .comparison import Report
from .likelihood import Estimate
from .prediction import THESIS

DIRECTION_SIGNS = {-1: "-", 1: "+"}


def print_calibration(result: Calibration, console: Console | None = None) -> None:
    """Parameters by both estimators, then the tests of the analysis of variance."""
    console = console or Console()
    console.print(_parameters(result))
    if result.effects:
        console.print(_effects(result))


def _parameters(result: Calibration) -> Table:
    table = Table(title=f"Step sizes from {len(result.runs)} runs")
    for heading in ("joint", "parameter", "routine", "likelihood", "± 95 %", "unit"):
        table.add_column(heading, justify="right")
    for (joint, direction), estimate in result.likelihood.items():
        chosen = result.routine[joint, direction]
        by_routine = {} if isinstance(chosen, str) else asdict(chosen)
        for i, name in enumerate(estimate.names):
            factor, unit = (1.0, "") if name == "recoil" else _unit(joint)
            table.add_row(
                f"{joint}{DIRECTION_SIGNS[direction]}" if i == 0 else "",
                name.replace("_", " "),
                f"{by_routine[name] * factor:.2f}" if by_routine else "-",
                f"{estimate.values[i] * factor:.2f}",
                _width(estimate, i, factor),
                unit,
                end_section=i == len(estimate.names) - 1,
            )
    return table


def _effects(result: Calibration) -> Table:
    table = Table(title="Analysis of variance: smallest and largest p of each factor")
    for heading in ("factor", "joint", "tests", "significant", "smallest p", "largest p"):
        table.add_column(heading, justify="right")
    for key in sorted({(effect.factor, effect.joint) for effect in result.effects}):
        tests = [effect for effect in result.effects if (effect.factor, effect.joint) == key]
        p = [effect.p_value for effect in tests]
        table.add_row(
            key[0],
            str(key[1]),
            str(len(tests)),
            str(sum(effect.significant for effect in tests)),
            f"{min(p):.2g}",
            f"{max(p):.2g}",
        )
    return table


def _unit(joint: int) -> tuple[float, str]:
    return (1e9, "nm") if joint == 3 else (1e6, "urad")


def _width(estimate: Estimate, i: int, factor: float) -> str:
    width = estimate.half_widths[i] * factor
    return f"{width:.2g}" if np.isfinite(width) else "no run to spare"


def print_comparison(result: Report, console: Console | None = None) -> None:
    """Prediction errors per joint and direction, then tip errors per distance."""
    console = console or Console()
    console.print(_predictions(result))
    console.print(
        "Thesis, worst case: model "
        + ", ".join(f"joint {joint} {100 * model:.0f} %" for joint, (model, _) in THESIS.items())
        + "; constant step "
        + ", ".join(f"joint {joint} {100 * flat:.1f} %" for joint, (_, flat) in THESIS.items())
        + " - which its own parameters contradict."
    )
    console.print(_growth(result))


def _predictions(result: Report) -> Table:
    table = Table(title=f"Prediction error of the step, rms / worst [%], truth: {result.truth}")
    table.add_column("joint", justify="right")
    parts = result.comparison.predictions
    for name in parts[0].errors:
        table.add_column(name, justify="right")
    for part in parts:
        table.add_row(
            f"{part.joint}{DIRECTION_SIGNS[part.direction]}",
            *(f"{100 * part.rms(n):.2f} / {100 * part.worst(n):.2f}" for n in part.errors),
        )
    return table


def _growth(result: Report) -> Table:
    table = Table(title="Tip error of open-loop moves, rms [um], truth: empirical")
    table.add_column("mm", justify="right")
    for name in result.growth.errors:
        table.add_column(name, justify="right")
    for i, distance in enumerate(result.growth.distances):
        table.add_row(
            f"{1e3 * distance:.1f}",
            *(f"{1e6 * result.growth.rms(name)[i]:.1f}" for name in result.growth.errors),
        )
    return table
