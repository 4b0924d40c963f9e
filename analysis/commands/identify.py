"""``gapscope identify MACHINE``: dynamic parameters of a closed chain, with the motion that shows them."""

from pathlib import Path
from typing import Annotated

import typer

from . import places


def identify(
    machine: Annotated[str, typer.Argument(help="2prr, replalink, 5r, mast or 3prs.")],
    out: Annotated[
        Path,
        typer.Option(
            callback=places.folder, help="Folder for identification.json, figures and SDF."
        ),
    ],
    methods: Annotated[
        str, typer.Option(help="Searches, by comma: gradient, pattern, evolution, cma.")
    ] = "gradient,evolution",
    budget: Annotated[
        int | None,
        typer.Option(min=500, help="Motions each search may try; by default the machine's number."),
    ] = None,
    repeats: Annotated[int, typer.Option(min=0, help="Repetitions of the noise.")] = 50,
    seed: Annotated[int, typer.Option(min=0, help="Of machine, noise and searches.")] = 0,
    at_rest: Annotated[
        bool,
        typer.Option(
            "--at-rest", help="Cycles start without speed, which the printed 2prr's do not."
        ),
    ] = False,
) -> None:
    """Base parameters, exciting motion, estimates with intervals, validation, SDF.

    The measurement is simulated by the machine's plant with closures, with planted parameters, friction and
    noise. `pattern` needs the optional extra `identification` of gapscope.
    """
    from dataclasses import replace

    from rich.progress import Progress
    from threadpoolctl import threadpool_limits

    from ..files import output_folder
    from ..identification import machines, report, study

    known, folder = machines.machine(machine), output_folder(out)
    if at_rest:
        known = replace(known, at_rest=True)
    wanted = tuple(word.strip() for word in methods.split(","))
    with Progress(transient=True) as progress, threadpool_limits(1):
        task = progress.add_task("identify", total=None)
        found = study.run(
            known,
            methods=wanted,
            budget=known.budget if budget is None else budget,
            seed=seed,
            repeats=repeats,
            progress=lambda step: progress.update(task, description=step),
        )
    report.summarise(found)
    for path in report.write(found, folder):
        typer.echo(f"wrote {path}")
