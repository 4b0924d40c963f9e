"""``gapscope rig MACHINE``: a virtual machine with a position controller, driven from a web page."""

from pathlib import Path
from typing import Annotated, Any

import typer

from ..rig.machines import NAMES
from . import places


def rig(
    machine: Annotated[
        str,
        typer.Argument(
            help=f"What stands behind the controller: {', '.join(NAMES)}, or an .urdf or .sdf file."
        ),
    ],
    out: Annotated[
        Path, typer.Option(callback=places.folder, help="Folder for the log sets measurement1, ...")
    ] = Path("out/rig"),
    fault: Annotated[
        str,
        typer.Option(
            help="What is wrong with it: none, mystery, friction, ...; a wrong name lists all."
        ),
    ] = "mystery",
    seed: Annotated[int, typer.Option(help="Of the fault and of where it stands.", min=0)] = 0,
    joints: Annotated[
        str,
        typer.Option(
            help="Of a model file, with commas; default all that move. Others are locked at 0."
        ),
    ] = "",
    settings: Annotated[
        Path | None,
        typer.Option(
            help="Of a model file: YAML with system, controller and sample_time_s as in a log set, and home: "
            "{JOINT: position}."
        ),
    ] = None,
    port: Annotated[int, typer.Option(help="Of the page on 127.0.0.1; 0 for any.", min=0)] = 8642,
) -> None:
    """Practise without hardware: home, jog, measure, diagnose, mend the model, measure again."""
    import time

    from ..rig import machines
    from ..rig.controller import Rig
    from ..rig.recorder import Recorder
    from ..rig.server import serve

    named = [name.strip() for name in joints.split(",") if name.strip()]
    built = machines.build(machine, fault, seed, joints=named, settings=settings)
    if machine not in NAMES:
        _tell(built.document())
    server = serve(Rig(built, Recorder(out), seed), port)
    typer.echo(f"{machine} at {server.url} (shut down there, or Ctrl-C); logs in {out}")
    try:
        while server.pacer.is_alive():
            time.sleep(0.1)
    except KeyboardInterrupt:
        pass
    finally:
        server.shutdown()
        server.server_close()
    if server.pacer.error is not None:
        raise server.pacer.error
    runs = server.rig.recorder.summary()
    if runs["runs"]:
        typer.echo(f"next: gapscope diagnose {runs['folder']}")


def _tell(document: dict[str, Any]) -> None:
    """What was taken from a model file, and what was assumed."""
    system, controller = document["system"], document["controller"]
    typer.echo(f"joints: {', '.join(system['joints'])}")
    for key in ("base", "locked", "payload"):
        if key in system:
            typer.echo(f"{key}: {system[key]}")
    for key in ("kp", "kd", "limit"):
        if key in controller:
            typer.echo(f"{key}: {controller[key]}")
