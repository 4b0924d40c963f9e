"""``gapscope simulate MACHINE``: run a diagram, write its log as a log set and a plot."""

import typer

app = typer.Typer(help="Simulate a machine and write its log set.", no_args_is_help=True)
