"""The thesis diagnosis in the terminal: verdict, ranking with its check, shrinkage."""

from rich.console import Console
from rich.table import Table

from .page import location_text, shrinkage_text
from .result import ThesisDiagnosis

ROWS = 5


def print_thesis(console: Console, diagnosis: ThesisDiagnosis) -> None:
    """Print verdict, best hypotheses, shrinkage and what the numbers say without a model."""
    d = diagnosis
    console.print(f"[bold]{d.verdict.verdict}[/bold]: {d.verdict.reason}")
    table = Table("hypothesis", "fitted, 2 Hz", "left out, 2 Hz", "held out, 1 Hz", "")
    for ranked, error, gone in list(zip(d.ranking, d.held_out_errors, d.refuted))[:ROWS]:
        table.add_row(
            ranked.fit.hypothesis.label,
            f"{100 * ranked.fit.rms:.1f} %",
            f"{100 * ranked.fit.held_out_rms:.1f} %",
            f"{100 * error:.1f} %",
            "refuted" if gone else "",
        )
    console.print(table)
    console.print(location_text(d))
    console.print(shrinkage_text(d))
    broken = [o for o in d.observations if o.significant and o.kind != "cross axis"]
    for o in sorted(broken, key=lambda o: -o.deviation):
        console.print(
            f"[yellow]note[/yellow]: {o.controller.upper()} at {o.rate_Hz:g} Hz, {o.quantity}: {o.value:.3g}, "
            f"where a linear drive has {'at most ' if o.kind == 'torque bound' else ''}{o.expected:.3g}"
        )
