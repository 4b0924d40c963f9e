"""A diagnosis in the terminal: the verdict first, then the ranking and the shrinkage."""

from rich.console import Console
from rich.table import Table

from .result import Diagnosis
from .shrinkage import LEVELS, Interval

ROWS = 6


def print_diagnosis(console: Console, diagnosis: Diagnosis) -> None:
    """Print verdict, best hypotheses, shrinkage and warnings."""
    console.print(f"[bold]{diagnosis.verdict.verdict}[/bold]: {diagnosis.verdict.reason}")
    table = Table("hypothesis", "probability", "held-out error", "gain over retuning")
    unit = diagnosis.machine.residual_unit
    for ranked in diagnosis.ranking[:ROWS]:
        low, high = ranked.gain_interval
        table.add_row(
            ranked.fit.hypothesis.label,
            f"{ranked.probability:.3f}",
            f"{ranked.fit.held_out_rms:.3g} {unit}",
            f"{ranked.gain:.2f} [{low:.2f}, {high:.2f}]",
        )
    console.print(table)
    s = diagnosis.shrinkage
    levels = (f"{name} {getattr(s, name):.3g}{_between(s.intervals[name])}" for name in LEVELS)
    console.print(f"{s.metric}: {', '.join(levels)}", highlight=False)
    if s.percent is not None and s.ci95 is not None:
        console.print(
            f"gap removed: {s.percent:.1f} % (95 % interval {s.ci95[0]:.1f} to {s.ci95[1]:.1f} %)"
        )
    for warning in diagnosis.warnings:
        console.print(f"[yellow]note[/yellow]: {warning}")


def _between(ends: Interval | None) -> str:
    return "" if ends is None else f" ({ends[0]:.3g} to {ends[1]:.3g})"
