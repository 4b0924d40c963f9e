"""``gapscope calibrate MACHINE``: parameters from a table of measurements, with intervals."""

from pathlib import Path
from typing import Annotated

import typer

from . import places

app = typer.Typer(help="Calibrate a machine from its measurements.", no_args_is_help=True)


@app.command("mm3a")
def mm3a(
    data: Annotated[Path, typer.Option(help="CSV table of step-counting runs.")],
    out: Annotated[
        Path, typer.Option(callback=places.folder, help="Folder for calibration.json and .png.")
    ] = Path("calibration"),
    method: Annotated[
        str, typer.Option(help="The routine's way to d: iteration, printed or exact.")
    ] = "iteration",
) -> None:
    """Step sizes of the MM3A: routine of chapter 6, maximum likelihood, analysis of variance.

    A table to try it on: `gapscope simulate mm3a --out steps.csv`.
    """
    from ..errors import InputError
    from ..mm3a import calibration, terminal
    from ..mm3a.routine import METHODS
    from ..mm3a.runs import read_runs

    if method not in METHODS:
        raise InputError("--method", f"unknown method {method!r}", f"one of {', '.join(METHODS)}")
    result = calibration.calibrate(read_runs(data), method)
    terminal.print_calibration(result)
    for path in calibration.write(result, out):
        typer.echo(f"wrote {path}")
