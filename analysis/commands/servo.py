"""``gapscope simulate 5r | 2prr | replalink | mast | 3prs``: mechatronic models of parallel machines."""

from collections.abc import Callable
from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from . import places


class Scheme(StrEnum):
    """Control schemes, as in ``diagrams.servo_loop``."""

    joint = "joint-space"
    workspace = "workspace"
    torque = "computed-torque"
    torque_workspace = "computed-torque-workspace"


class Coupling(StrEnum):
    """How the machine acts on its axes, as in ``diagrams.servo_loop``."""

    disturbance = "disturbance"
    plant = "plant"


TITLES = {
    "5r": "Five-bar with gears, cascaded loops and friction of Table 4.1 (Roldan, 4.1): x-move, circle, fast-circle.",
    "2prr": "2-PRR on belts (Roldan, 6.1): pick-and-place, circle.",
    "replalink": "RePlaLink, light motors under heavy links (Roldan, 6.2), as one plant: line, circle.",
    "mast": "2PRU-1PRS table on belts (Roldan, 4.2): lift, psi, theta.",
    "3prs": "3-PRS table on flexures (Ruiz et al. 2016): lift, tilt.",
}


def command(name: str) -> Callable[..., None]:
    """The command of one machine."""

    def simulate(
        out: Annotated[
            Path,
            typer.Option(
                callback=places.folder, help="Folder for run1.csv, run1.png and logset.yaml."
            ),
        ] = Path(f"out/simulate-{name}"),
        controller: Annotated[Scheme, typer.Option(help="Control scheme.")] = Scheme.joint,
        motion: Annotated[
            str | None, typer.Option(help="One of those above; by default the first.")
        ] = None,
        coupling: Annotated[
            Coupling | None,
            typer.Option(help="Machine as a disturbance (Fig. 3.4), or one coupled plant."),
        ] = None,
        gain: Annotated[
            float | None, typer.Option(help="k_v [1/s]; by default the machine's.", min=0.0)
        ] = None,
        feedforward: Annotated[
            float | None,
            typer.Option(
                help="Share of the reference's rate fed forward; by default the machine's.", min=0.0
            ),
        ] = None,
        current_bandwidth: Annotated[
            float | None,
            typer.Option(
                help="Of a current loop around the windings [Hz], 5r only; by default the current asked for flows.",
                min=1.0,
            ),
        ] = None,
    ) -> None:
        _simulate(name, out, controller, motion, coupling, gain, feedforward, current_bandwidth)

    simulate.__doc__ = TITLES[name]
    return simulate


def _simulate(  # type: ignore[no-untyped-def]
    name, out, controller, motion, coupling, gain, feedforward, current_bandwidth
) -> None:
    from rich.progress import Progress

    from ...diagrams import servo_loop
    from ..errors import InputError
    from ..mechatronic import servo_machines, servo_run

    if current_bandwidth is not None and name != "5r":
        raise InputError(
            "--current-bandwidth",
            f"the windings of {name} are not known",
            "the option with 5r alone",
            "Leave it out: the current asked for flows.",
        )
    machine = servo_machines.servo_machine(name)
    chosen, path = servo_machines.motion(machine, motion)
    given = {
        "position_gain": machine.gains.get(chosen) if gain is None else gain,
        "feedforward": feedforward,
        "coupling": None if coupling is None else servo_loop.Coupling(coupling.value),
        "current_loop": servo_run.current_loop(current_bandwidth),
    }
    loop = machine.loop(
        scheme=servo_loop.Scheme(controller.value),
        **{key: value for key, value in given.items() if value is not None},
    )
    with Progress(transient=True) as progress:
        task = progress.add_task("simulate", total=1.0)
        run = servo_run.simulate(
            loop, path, chosen, progress=lambda share: progress.update(task, completed=share)
        )
    for quantity, value in run.numbers().items():
        typer.echo(f"{quantity.replace('_', ' ')}: {value:.4g}")
    for written in servo_run.write(machine, run, out):
        typer.echo(written)


COMMANDS = {name: command(name) for name in TITLES}
