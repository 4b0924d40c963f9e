"""``gapscope simulate MACHINE``: run a diagram, write its log as a log set and a plot."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from . import places

app = typer.Typer(help="Simulate a machine and write its log set.", no_args_is_help=True)


class Controller(StrEnum):
    """Controllers of the C-drive."""

    pd = "pd"
    ts = "ts"
    ct = "ct"
    ra = "ra"


@app.command("c-drive")
def c_drive(
    controller: Annotated[
        Controller | None,
        typer.Option(help="PD, task-space PD, computed torque or resolved acceleration."),
    ] = None,
    motion: Annotated[
        str | None,
        typer.Option(help="Motion of Table 5-2 (translation, rotation, helical) or a motion file."),
    ] = None,
    rate: Annotated[float | None, typer.Option(help="Cycles per second [Hz].")] = None,
    cycles: Annotated[int | None, typer.Option(help="Number of cycles.")] = None,
    config: Annotated[
        Path | None, typer.Option(help="YAML file of settings; options win over it.")
    ] = None,
    out: Annotated[
        Path,
        typer.Option(callback=places.folder, help="Folder for logset.yaml, run1.csv and run1.png."),
    ] = Path("out/simulate-c-drive"),
) -> None:
    """Simulate the C-drive's loop on Drake: encoder, controller, amplifier, plant."""
    from ...diagrams import c_drive_config
    from .. import simulation
    from ..errors import InputError

    try:
        settings = (
            c_drive_config.load_config(config) if config else c_drive_config.CDriveLoopConfig()
        )
    except (OSError, ValueError) as error:
        found, _, expected = str(error).partition("; expected ")
        raise InputError(
            "--config", found, expected or "YAML as in the packaged diagrams/c_drive_loop.yaml"
        ) from None
    if controller is not None:
        kind = c_drive_config.CONTROLLERS[controller.value]
        if not isinstance(settings.controller, kind):
            settings.controller = kind()
    for name, value in (("motion", motion), ("rate", rate), ("cycles", cycles)):
        if value is not None:
            setattr(settings, name, value)
    run = simulation.simulate_c_drive(settings)
    for path in simulation.write_c_drive_run(run, out):
        typer.echo(path)


@app.command("mm3a")
def mm3a(
    out: Annotated[
        Path,
        typer.Option(
            callback=places.beside,
            help="CSV table of runs to write; with --moves, folder of a log set.",
        ),
    ],
    truth: Annotated[
        str, typer.Option(help="What moves the joints: empirical or physical.")
    ] = "empirical",
    days: Annotated[int, typer.Option(help="Days of measurement.", min=1)] = 2,
    repeats: Annotated[int, typer.Option(help="Repeats of each run a day.", min=1)] = 3,
    seed: Annotated[int, typer.Option(help="Of the random generator.", min=0)] = 0,
    moves: Annotated[
        bool, typer.Option("--moves", help="Write measured moves, a log set for diagnose, instead.")
    ] = False,
    effect: Annotated[
        list[str] | None,
        typer.Option(help="With --moves: an effect that the stated model lacks; repeatable."),
    ] = None,
) -> None:
    """Calibration experiments of the MM3A (Damani 2013, chapters 4-6) through the audio switch.

    With --moves: two days of short measured moves of joints 2 and 3.
    """
    from ..errors import InputError
    from ..files import output_folder
    from ..mm3a import experiments
    from ..mm3a.runs import write_runs

    if moves:
        from ..mm3a.simulated_moves import write

        for path in write(out, truth, effect or [], seed):
            typer.echo(path)
        return
    if effect:
        raise InputError("--effect", "there are no moves to put it in", "--moves beside it")
    output_folder(out.parent)
    runs = experiments.full_experiment(truth, days=days, repeats=repeats, seed=seed)
    write_runs(out, runs)
    typer.echo(f"wrote {out}: {len(runs)} runs")
