"""``gapscope bandwidth MACHINE``: up to which frequency a machine follows."""

from pathlib import Path
from typing import Annotated

import typer

from . import places

app = typer.Typer(help="Closed-loop bandwidth of a machine.", no_args_is_help=True)


@app.callback()
def _machines() -> None:
    """Keep the machine's name a command of its own while there is only one."""


@app.command("mast")
def mast(
    out: Annotated[
        Path,
        typer.Option(callback=places.folder, help="Folder for bandwidth.json and bandwidth.png."),
    ],
    position_gain: Annotated[float | None, typer.Option(help="k_v [1/s].", min=0.0)] = None,
    position_period: Annotated[
        float | None, typer.Option(help="Sample time of the position loop [s].", min=1e-3)
    ] = None,
    velocity_bandwidth: Annotated[
        float | None, typer.Option(help="Of the speed loop [rad/s].", min=1.0, max=1000.0)
    ] = None,
) -> None:
    """2PRU-1PRS table in z, psi and theta beside Roldan's section 4.2.4 (gains are assumed)."""
    from dataclasses import replace

    from rich.console import Console

    from ...models.belt_control import Gains
    from ..mechatronic import mast_report
    from ..mechatronic.mast_study import study

    options = {
        "position_gain": position_gain,
        "position_period": position_period,
        "velocity_bandwidth": velocity_bandwidth,
    }
    gains = replace(Gains(), **{k: v for k, v in options.items() if v is not None})
    result = study(gains)
    console = Console()
    console.print(mast_report.table(result))
    console.print(mast_report.variant_table(result))
    for remark in mast_report.remarks(result):
        typer.echo(f"- {remark}")
    for path in mast_report.write(result, out):
        typer.echo(path)
