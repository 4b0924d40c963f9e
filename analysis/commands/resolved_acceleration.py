"""``gapscope compare resolved-acceleration``: why it became unstable in the thesis."""

from pathlib import Path
from typing import Annotated

import typer

from . import places


def resolved_acceleration(
    out: Annotated[
        Path, typer.Option(callback=places.folder, help="Folder for the JSON file and two figures.")
    ],
) -> None:
    """Stability of resolved acceleration over its two gains, beside the printed tuning."""
    from rich.console import Console
    from rich.table import Table

    from .. import resolved_acceleration as study

    console = Console()
    with console.status("eigenvalues of the sampled loop"):
        result = study.study()
        written = study.write_study(result, out)
    table = Table(title="Printed gain / largest stable gain")
    table.add_column("torque path")
    for gain in result.limits["ideal"]:
        table.add_column(gain.name, justify="right")
    for name, found in result.limits.items():
        table.add_row(name, *(f"{gain.share:.2f}" for gain in found))
    console.print(table)
    for path in written:
        typer.echo(path)
