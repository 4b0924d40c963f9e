"""``gapscope compare MACHINE``: controllers beside the printed results."""

from pathlib import Path
from typing import Annotated

import typer

from . import places
from .resolved_acceleration import resolved_acceleration

app = typer.Typer(help="Compare controllers of a machine.", no_args_is_help=True)
app.command("resolved-acceleration")(resolved_acceleration)

Out = Annotated[
    Path, typer.Option(callback=places.folder, help="Folder for the results, made if missing.")
]


@app.command("c-drive")
def c_drive(out: Out) -> None:
    """Tables 5-4 to 5-9 of the C-drive: our simulation beside the printed one and the experiment."""
    from ..comparison import compare_c_drive
    from ..comparison_page import write_comparison

    for path in write_comparison(compare_c_drive(), out):
        typer.echo(path)


@app.command("ct-errors")
def ct_errors(out: Out) -> None:
    """Which setting reproduces the printed errors of computed torque? Every variant tried."""
    from ..ct_error_study import run_study, write_study

    for path in write_study(run_study(), out):
        typer.echo(path)


@app.command("mm3a")
def mm3a(
    truth: Annotated[
        str, typer.Option(help="What moves the joints: empirical or physical.")
    ] = "empirical",
    out: Annotated[
        Path, typer.Option(callback=places.folder, help="Folder for comparison.json and plots.")
    ] = Path("compare-mm3a"),
    seed: Annotated[int, typer.Option(help="Of the random generator.", min=0)] = 0,
) -> None:
    """Step models of the MM3A against a constant step and none (Damani 2013, chapter 7)."""
    from ..mm3a import comparison, terminal

    result = comparison.report(truth, seed)
    terminal.print_comparison(result)
    for path in comparison.write(result, out):
        typer.echo(f"wrote {path}")


@app.command("diagnoses")
def diagnoses(
    results: Annotated[
        list[Path], typer.Argument(help="Folders of `gapscope diagnose`, two or more.")
    ],
    out: Out,
) -> None:
    """Diagnoses side by side: verdicts, effects, shrinkage and where each gap lies, on one page."""
    from ..gap.report.compare import load, write_comparison

    typer.echo(write_comparison(load(results), out))
