"""``gapscope data``: public measured log sets."""

from pathlib import Path
from typing import Annotated

import typer

from . import places

app = typer.Typer(help="Public measured log sets.", no_args_is_help=True)


@app.command("list")
def list_sets() -> None:
    """Names, sources, addresses of the originals and licences of the sets that are known."""
    from rich.console import Console
    from rich.table import Table

    from ..datasets import known_sets

    table = Table("name", "source", "original", "licence")
    for name, entry in known_sets().items():
        table.add_row(name, entry["source"], entry["original"], entry["license"])
    Console().print(table)


@app.command("get")
def get_set(
    name: Annotated[str, typer.Argument(help="Name of the set, see `gapscope data list`.")],
    out: Annotated[
        Path | None, typer.Option(callback=places.folder, help="Folder to write; default NAME.")
    ] = None,
    url: Annotated[
        str | None, typer.Option(help="Mirror that has NAME/FILE; needs gapscope[data].")
    ] = None,
    original: Annotated[
        Path | None, typer.Option(help="The published file (emps: EMPS.zip or DATA_EMPS.mat).")
    ] = None,
) -> None:
    """Fetch a set and check its hashes.

    From --original or --url, else from the folder GAPSCOPE_DATA names, else from where it is published: of emps
    the archive is downloaded (needs gapscope[data]) and made into a table, the others say where they are.
    """
    from ..datasets import get

    for path in get(name, out or Path(name), url=url, original=original):
        typer.echo(path)
