"""``gapscope compare MACHINE``: controllers beside the printed results."""

import typer

app = typer.Typer(help="Compare controllers of a machine.", no_args_is_help=True)
