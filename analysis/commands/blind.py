"""``gapscope blind``: diagnose sealed cases of an independent machine and score the answers."""

from pathlib import Path
from typing import Annotated

import typer

from . import places
from .sharing import Cluster, Workers


def blind(
    seed: Annotated[int, typer.Option(help="Below 1000 to tune on, from 1000 to report on.")],
    out: Annotated[
        Path,
        typer.Option(callback=places.folder, help="Folder of the run; the same folder resumes it."),
    ],
    cases: Annotated[int, typer.Option(min=1, help="Number of cases; decks of 40.")] = 200,
    machine: Annotated[
        str, typer.Option(help="What the cases are of: drive, or mm3a with physical actuators.")
    ] = "drive",
    workers: Workers = 1,
    cluster: Cluster = None,
) -> None:
    """Write sealed cases, diagnose them, open the answers and print the score."""
    from rich.console import Console
    from rich.markdown import Markdown
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn

    from .. import blind_check, blind_report, blind_score

    console = Console()
    console.print(f"seed {seed}: results of this run are for [bold]{blind_check.label(seed)}[/]")
    digests = []

    def announce(digest: str) -> None:
        digests.append(digest)
        console.print(f"answers sealed: sha256 {digest}")

    columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=console) as bar:
        tasks = {stage: bar.add_task(stage, total=cases) for stage in ("write", "diagnose")}
        opened = blind_check.run(
            seed=seed,
            cases=cases,
            out=out,
            machine=machine,
            workers=workers,
            cluster=cluster,
            progress=lambda stage, done, total: bar.update(tasks[stage], completed=done),
            sealed=announce,
        )
    outcomes = [blind_score.outcome(answer, result) for answer, result in opened]
    blind_report.write(outcomes, seed=seed, digest=digests[0], out=out)
    console.print(Markdown((out / "blind.md").read_text()))
