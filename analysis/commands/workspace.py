"""``gapscope workspace MACHINE``: what a machine reaches, how well, and whether a task fits."""

from pathlib import Path
from typing import Annotated

import typer

from . import places
from .sharing import Cluster, Workers

app = typer.Typer(help="Analyse the workspace of a machine.", no_args_is_help=True)


@app.callback()
def _machines() -> None:
    """Analyse the workspace of a machine."""


@app.command("pmc")
def pmc(
    out: Annotated[
        Path,
        typer.Option(
            callback=places.folder,
            help="Folder for workspace.json, maps.csv, figures and 3-D page.",
        ),
    ],
    grid: Annotated[int, typer.Option(min=2, help="Optimisations a side of each surface.")] = 13,
    workers: Workers = 1,
    cluster: Cluster = None,
    design: Annotated[
        bool, typer.Option(help="Optimise the dimensions, too (minutes): design.json and .png.")
    ] = False,
) -> None:
    """PepperMill-Carrier: reachable workspace, rotatability, largest bodies, industry cycle.

    Optimised rows are kept in OUT/.rows; a run that was interrupted goes on where it stopped.
    """
    from rich.progress import Progress

    from ...models.pmc.geometry import Geometry
    from ..files import output_folder, write_whole
    from ..pmc import maps, workspace, workspace_page, workspace_plots

    folder = output_folder(out)
    with Progress(transient=True) as progress:
        task = progress.add_task("optimising surfaces")
        result = workspace.study(
            Geometry(),
            folder / ".rows",
            grid=grid,
            workers=workers,
            cluster=cluster,
            progress=lambda done, total: progress.update(task, completed=done, total=total),
        )
    write_whole(folder / "workspace.json", workspace.dumps(result))
    write_whole(folder / "workspace.html", workspace_page.page(result))
    write_whole(folder / "maps.csv", maps.table(maps.maps(result.geometry)))
    workspace_plots.draw_all(result, folder)
    if design:
        _optimise_design(folder)
    _print_summary(workspace.findings(result))
    typer.echo(f"wrote {folder / 'workspace.json'}, maps.csv, workspace.html and figures")


def _optimise_design(folder: Path) -> None:
    import json

    from ...models.pmc.parameters import PMCParameters
    from ..files import write_whole
    from ..pmc import design as study
    from ..pmc import design_plot

    result = study.optimise(PMCParameters())
    text = json.dumps(study.findings(result), indent=1, allow_nan=False)
    write_whole(folder / "design.json", text + "\n")
    write_whole(folder / "design.png", design_plot.png(result))


def _print_summary(found: dict) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("workspace", "volume", "largest cuboid", "largest cylinder")
    for name, volume in found["volumes_m3"].items():
        bodies = found["inscribed"].get(name)
        cells = (
            [f"{1e3 * bodies[body]['volume_m3']:.2f} l" for body in ("cuboid", "cylinder")]
            if bodies
            else ["", ""]
        )
        table.add_row(name, f"{1e3 * volume['value']:.2f} l", *cells)
    console = Console()
    console.print(table)
    check, cycle = found["surfaces"]["check"], found["industry_cycle"]
    verdict = "confirmed" if check["confirmed"] else "NOT confirmed"
    console.print(
        f"{check['optima']} optimised heights {verdict}: KKT residual at most "
        f"{check['kkt_residual_max']:.1e}, {check['exact_error_max_m']:.1e} m from the exact solution"
    )
    console.print(f"industry cycle fits: {'yes' if cycle['fits'] else 'no'}")
