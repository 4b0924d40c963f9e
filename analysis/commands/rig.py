"""``gapscope rig MACHINE``: a virtual machine with a position controller, driven from a web page."""

from pathlib import Path
from typing import Annotated

import typer

from ..rig.machines import NAMES
from . import places


def rig(
    machine: Annotated[
        str, typer.Argument(help=f"What stands behind the controller: {', '.join(NAMES)}.")
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
    port: Annotated[int, typer.Option(help="Of the page on 127.0.0.1; 0 for any.", min=0)] = 8642,
) -> None:
    """Practise without hardware: home, jog, measure, diagnose, mend the model, measure again."""
    import time

    from ..rig import machines
    from ..rig.controller import Rig
    from ..rig.recorder import Recorder
    from ..rig.server import serve

    built = machines.build(machine, fault, seed)
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
