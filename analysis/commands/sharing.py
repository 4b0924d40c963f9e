"""Options of every command that shares its cases among workers."""

from typing import Annotated

import typer

Workers = Annotated[int, typer.Option(min=1, help="Processes of this machine.")]
Cluster = Annotated[
    str | None,
    typer.Option(help="Dask scheduler such as tcp://host:8786; needs gapscope[cluster]."),
]
