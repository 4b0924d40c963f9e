"""``gapscope simulate 5r`` and ``gapscope compare 5r``: the five-bar's mechatronic model."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from . import places


class Scheme(StrEnum):
    """Control schemes, as in ``diagrams.five_bar_loop``."""

    joint = "joint-space"
    workspace = "workspace"
    torque = "computed-torque"
    torque_workspace = "computed-torque-workspace"


class Coupling(StrEnum):
    """How the machine acts on its axes, as in ``diagrams.five_bar_loop``."""

    disturbance = "disturbance"
    plant = "plant"


class Motion(StrEnum):
    """Paths of Roldan's section 4.1.4."""

    line = "x-move"
    circle = "circle"
    fast = "fast-circle"


def simulate(
    out: Annotated[
        Path,
        typer.Option(callback=places.folder, help="Folder for logset.yaml, run1.csv and run1.png."),
    ] = Path("out/simulate-5r"),
    controller: Annotated[Scheme, typer.Option(help="Control scheme.")] = Scheme.joint,
    motion: Annotated[Motion, typer.Option(help="Path of the tool.")] = Motion.line,
    coupling: Annotated[
        Coupling, typer.Option(help="Machine as a disturbance (Fig. 3.4), or one coupled plant.")
    ] = Coupling.disturbance,
    gain: Annotated[
        float | None, typer.Option(help="k_v [1/s]; by default the printed one.", min=0.0)
    ] = None,
    feedforward: Annotated[
        float, typer.Option(help="Share of the reference's rate fed forward.", min=0.0)
    ] = 0.0,
    current_bandwidth: Annotated[
        float | None,
        typer.Option(
            help="Of a current loop around the motors' windings [Hz]; by default the current asked for flows.",
            min=1.0,
        ),
    ] = None,
) -> None:
    """Five-bar with gears, cascaded loops and friction of Table 4.1 (Roldan, section 4.1)."""
    from ...diagrams import five_bar_loop
    from ..mechatronic import five_bar_run

    inner = five_bar_run.current_loop(current_bandwidth)
    loop = five_bar_loop.FiveBarLoop(
        current_loop=inner,
        scheme=five_bar_loop.Scheme(controller.value),
        coupling=five_bar_loop.Coupling(coupling.value),
        position_gain=five_bar_run.GAINS[motion.value] if gain is None else gain,
        feedforward=feedforward,
    )
    run = five_bar_run.simulate(loop, motion.value)
    for name, value in run.numbers().items():
        typer.echo(f"{name.replace('_', ' ')}: {value:.4g}")
    for path in five_bar_run.write(run, out):
        typer.echo(path)


def compare(
    out: Annotated[Path, typer.Option(callback=places.folder, help="Folder for comparison.json.")],
) -> None:
    """Friction identification, X move and circles of the five-bar beside Roldan's section 4.1."""
    from rich.console import Console

    from ..mechatronic import five_bar_study

    rows = five_bar_study.study()
    Console().print(five_bar_study.table(rows))
    for path in five_bar_study.write(rows, out):
        typer.echo(path)
