"""``gapscope bench``: how fast this machine runs the toolbox, beside peers and the limit."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from . import places


class GroupName(StrEnum):
    """What can be measured."""

    loop = "closed-loop"
    many = "monte-carlo"
    robots = "mechanisms"
    sizes = "growth"
    start = "start-up"
    first = "first-diagnosis"
    fit = "one-fit"
    diagnosis = "diagnosis"


def bench(
    out: Annotated[
        Path, typer.Option(callback=places.folder, help="Folder for bench.json and bench.png.")
    ],
    quick: Annotated[bool, typer.Option("--quick", help="Fewer rounds, wider spread.")] = False,
    group: Annotated[
        list[GroupName] | None, typer.Option(help="Measure only this group; repeatable.")
    ] = None,
    open_sets: Annotated[
        Path | None,
        typer.Option(
            "--open",
            help="Folder of log sets to diagnose; by default gap/open beside GAPSCOPE_DATA.",
        ),
    ] = None,
    sets: Annotated[
        int | None,
        typer.Option(min=1, help="Parameter sets of monte-carlo; by default 20000, quick 1000."),
    ] = None,
) -> None:
    """Time closed loop, Monte Carlo, mechanisms, growth, start-up, one fit and diagnosis in interleaved rounds; exit code 1 on disagreement."""
    from rich.console import Console

    from ..benchmarks import report, study

    before = report.machine()
    groups = []
    for name in group or list(GroupName):
        with Console(stderr=True).status(f"measuring {name.value}"):
            groups.append(study.measured(name.value, quick, open_sets, sets))
        Console().print(report.table(groups[-1]))
    for path in report.write(groups, before, report.machine(), out):
        typer.echo(path)
    if not all(row.agrees for one in groups for row in one.rows):
        raise typer.Exit(1)
