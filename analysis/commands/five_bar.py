"""``gapscope compare 5r`` and ``gapscope compare couplings``: mechatronic models beside the printed ones."""

from pathlib import Path
from typing import Annotated

import typer

from . import places


def compare(
    out: Annotated[Path, typer.Option(callback=places.folder, help="Folder for comparison.json.")],
) -> None:
    """Friction identification, X move and circles of the five-bar beside Roldan's section 4.1."""
    from rich.console import Console

    from ..mechatronic import five_bar_study, five_bar_variants

    rows, variants = five_bar_study.study(), five_bar_variants.variants()
    console = Console()
    console.print(five_bar_study.table(rows))
    console.print(five_bar_study.variant_table(variants))
    for path in five_bar_study.write(rows, variants, out):
        typer.echo(path)


def couplings(
    out: Annotated[
        Path, typer.Option(callback=places.folder, help="Folder for couplings.json and .png.")
    ],
) -> None:
    """When does the machine as a disturbance of its axes (Fig. 3.4) differ from one coupled plant?"""
    from rich.console import Console
    from rich.progress import Progress

    from ..mechatronic import couplings as study

    with Progress(transient=True) as progress:
        task = progress.add_task("couplings", total=1.0)
        rows = study.sweep(lambda share: progress.update(task, completed=share))
    Console().print(study.table(rows))
    for path in study.write(rows, out):
        typer.echo(path)
