"""``gapscope simulate pmc`` and ``gapscope compare pmc``: the PepperMill-Carrier."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from . import places
from .sharing import Cluster, Workers

Out = Annotated[Path, typer.Option(callback=places.folder, help="Folder for the results.")]


class Controller(StrEnum):
    """Controllers of the PepperMill-Carrier."""

    ts = "ts"
    pd = "pd"
    ct = "ct"
    ra = "ra"


class Cycle(StrEnum):
    """Test cycles."""

    industry = "industry"
    smooth = "smooth"


def simulate(
    out: Out,
    controller: Annotated[
        Controller | None,
        typer.Option(
            help="Task-space PD (Table 5-10, default), joint PD, computed torque, resolved acceleration."
        ),
    ] = None,
    cycle: Annotated[
        Cycle | None, typer.Option(help="25-300-25 mm with half a turn, as printed or rounded.")
    ] = None,
    cycles: Annotated[float, typer.Option(min=0.01, help="How many cycles.")] = 1.0,
    speed: Annotated[
        float | None, typer.Option(help="1, the default, is the printed 0.3 Hz.")
    ] = None,
    config: Annotated[
        Path | None, typer.Option(help="YAML file of settings; options win over it.")
    ] = None,
    replay: Annotated[bool, typer.Option(help="Write the 3-D replay, too.")] = True,
) -> None:
    """PepperMill-Carrier: run a Drake diagram; log set, figure and 3-D replay.

    Writes logset.yaml, run.csv, run.png and replay.html.
    """
    from rich.progress import Progress

    from ...diagrams.pmc_loop import PMCLoopConfig
    from ..errors import InputError
    from ..pmc import simulation

    try:
        settings = PMCLoopConfig.load(config) if config else PMCLoopConfig()
    except (RuntimeError, OSError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(config, str(error), "YAML with the fields of PMCLoopConfig") from error
    for name, value in (("controller", controller), ("cycle", cycle), ("speed", speed)):
        if value is not None:
            setattr(settings, name, getattr(value, "value", value))
    with Progress(transient=True) as bar:
        task = bar.add_task("simulating")
        run = simulation.simulate(
            settings,
            out,
            cycles=cycles,
            replay=replay,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    errors = abs(simulation.pose_errors(run)).max(axis=0)
    typer.echo(
        f"largest errors: x {1e3 * errors[0]:.2f}, y {1e3 * errors[1]:.2f}, z {1e3 * errors[2]:.2f} mm, "
        f"rotation {errors[3]:.3f} rad"
    )
    typer.echo(f"wrote {out / 'logset.yaml'}, run.csv, run.png" + (", replay.html" * replay))


def compare(out: Out) -> None:
    """PepperMill-Carrier: four controllers on two cycles, with and without the counterweight.

    Writes comparison.json, comparison.md, comparison.png and prototype.png.
    """
    from ..pmc import comparison

    result = comparison.compare()
    comparison.write(result, out)
    typer.echo(comparison.finding(result))
    typer.echo(f"wrote {out / 'comparison.json'}, comparison.md, comparison.png, prototype.png")


def flaws(
    out: Out,
    only: Annotated[
        list[str] | None, typer.Option(help="A flaw to try, all by default; may be repeated.")
    ] = None,
    seed: Annotated[
        list[int] | None,
        typer.Option(min=0, help="Draws the robot's deviations, 50 by default; may be repeated."),
    ] = None,
    workers: Workers = 1,
    cluster: Cluster = None,
) -> None:
    """PepperMill-Carrier: diagnose logs of an independent robot with flaws the diagnosis is not told.

    Writes a log set and diagnosis.json for each, flaws.json and flaws.md. Finished flaws are kept in OUT/.done;
    a run that was interrupted goes on where it stopped.
    """
    import json

    from rich.console import Console
    from rich.progress import BarColumn, MofNCompleteColumn, Progress, TimeRemainingColumn
    from rich.table import Table

    from ..errors import InputError
    from ..files import output_folder, write_whole
    from ..pmc import flaw_report
    from ..pmc import flaws as study
    from ..resumable import resumable_map

    names = only or list(study.FLAWS)
    for name in names:
        if name not in study.FLAWS:
            raise InputError("--only", f"{name!r}", f"one of {', '.join(study.FLAWS)}")
    folder = output_folder(out)
    cases = [
        {"name": name, "into": str(folder), "seed": number}
        for number in seed or [study.REPORTED_FROM]
        for name in names
    ]
    columns = ("{task.description}", BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, transient=True) as bar:
        task = bar.add_task("diagnosing", total=len(cases))
        outcomes = resumable_map(
            study.trial,
            cases,
            folder / ".done",
            workers=workers,
            cluster=cluster,
            progress=lambda done, total: bar.update(task, completed=done, total=total),
        )
    write_whole(folder / "flaws.json", json.dumps(outcomes, indent=1) + "\n")
    write_whole(folder / "flaws.md", flaw_report.markdown(outcomes))
    table = Table("flaw", "seed", "verdict", "best hypothesis", "gap removed")
    for outcome in outcomes:
        table.add_row(*flaw_report.cells(outcome))
    Console().print(table, *flaw_report.summary(outcomes), sep="\n")
    typer.echo(f"wrote {folder / 'flaws.md'}, flaws.json and a diagnosis for each log")
