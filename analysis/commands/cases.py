"""``gapscope cases``: every log set at hand, diagnosed, on one page."""

from pathlib import Path
from typing import Annotated

import typer

from . import places


def cases(
    out: Annotated[Path, typer.Option(callback=places.file, help="Page to write, Markdown.")],
    data: Annotated[
        Path,
        typer.Option(envvar="GAPSCOPE_DATA", help="Folder of the measured log sets."),
    ],
    simulated: Annotated[
        Path | None,
        typer.Option(help="Folder of simulated log sets; default gap/open beside the measured."),
    ] = None,
    work: Annotated[
        Path, typer.Option(help="Folder of finished diagnoses, taken up by a second run.")
    ] = Path("out/cases"),
    seed: Annotated[int, typer.Option(help="Seed of the bootstrap.")] = 0,
) -> None:
    """Diagnose every log set at hand and write one page of what was found and what was not.

    Delete the folder of finished diagnoses after a change of the instrument or of the data.
    """
    from rich.progress import Progress

    from ..gap.cases import log_sets, write_cases

    sections = [("Measured sets", log_sets(data))]
    beside = simulated or data.resolve().parent / "gap" / "open"
    if simulated is not None or beside.is_dir():
        sections.append(("Simulated sets, by an independent generator", log_sets(beside)))
    with Progress(transient=True) as bar:
        task = bar.add_task("log sets", total=None)
        page = write_cases(
            sections, out, work, seed=seed,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )  # fmt: skip
    typer.echo(page)
