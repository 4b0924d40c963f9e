"""The command line ``gapscope``: wiring only, each command is a module of ``commands``."""

import sys
from importlib.metadata import version
from typing import Annotated

import typer

from .commands import (
    bandwidth,
    bench,
    blind,
    calibrate,
    cases,
    compare,
    data,
    demo,
    design,
    diagnose,
    five_bar,
    identify,
    importing,
    parallel_workspace,
    pmc,
    rig,
    servo,
    simulate,
    view,
    workspace,
)

app = typer.Typer(
    name="gapscope",
    help="Where is the sim-to-real gap, what causes it, and how far does it shrink?",
    no_args_is_help=True,
    rich_markup_mode="markdown",  # the default drops what is in brackets: units, names of extras
    pretty_exceptions_enable=False,
)
app.add_typer(simulate.app, name="simulate")
app.add_typer(compare.app, name="compare")
app.add_typer(bandwidth.app, name="bandwidth")
app.add_typer(workspace.app, name="workspace")
for _name, _command in parallel_workspace.COMMANDS.items():
    workspace.app.command(_name)(_command)
simulate.app.command("pmc")(pmc.simulate)
for _name, _command in servo.COMMANDS.items():
    simulate.app.command(_name)(_command)
compare.app.command("pmc")(pmc.compare)
compare.app.command("pmc-flaws")(pmc.flaws)
compare.app.command("5r")(five_bar.compare)
compare.app.command("couplings")(five_bar.couplings)
app.add_typer(calibrate.app, name="calibrate")
app.command("diagnose")(diagnose.diagnose)
app.command("design")(design.design)
app.command("identify")(identify.identify)
app.command("import")(importing.import_logs)
app.add_typer(data.app, name="data")
app.command("demo")(demo.demo)
app.command("blind")(blind.blind)
app.command("cases")(cases.cases)
app.command("rig")(rig.rig)
app.command("bench")(bench.bench)
app.command("view")(view.view)


def _print_version(wanted: bool) -> None:
    if wanted:
        typer.echo(f"gapscope {version('gapscope')}")
        raise typer.Exit


@app.callback()
def _options(
    version: Annotated[
        bool,
        typer.Option("--version", callback=_print_version, is_eager=True, help="Print version."),
    ] = False,
) -> None:
    """Options of the program as a whole."""


def main() -> None:
    """Run the command line; unusable input ends in one message and exit code 2."""
    from .errors import InputError

    try:
        app()
    except InputError as error:
        typer.secho(f"gapscope: {error}", fg="red", err=True)
        sys.exit(2)
