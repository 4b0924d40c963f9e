"""``gapscope view MACHINE``: a machine with sliders, a log with ghosts, a block diagram."""

from pathlib import Path
from typing import Annotated

import typer

from . import places


def view(
    machine: Annotated[str, typer.Argument(help="c-drive, slider, pmc, mm3a or 5r.")],
    log: Annotated[
        Path | None, typer.Option(help="Log set of it: replay a run beside its models.")
    ] = None,
    run: Annotated[
        str | None, typer.Option(help="Run of the log set; default the first held out.")
    ] = None,
    magnify: Annotated[
        float | None, typer.Option(help="Enlarge differences of the models; default 5 % of motion.")
    ] = None,
    blocks: Annotated[
        bool, typer.Option(help="Block diagram of its loop as SVG, instead.")
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            callback=places.file, help="File to write; without it sliders are served until Escape."
        ),
    ] = None,
) -> None:
    """Look at a machine: live with sliders, or a self-contained page with --out."""
    from ..files import output_folder, write_whole

    if blocks:
        content, default = _blocks(machine), f"{machine}.svg"
    elif log is not None:
        content, default = _replay(machine, log, run, magnify), "replay.html"
    elif out is not None:
        from ..view.scene import still_page
        from ..view.skeletons import skeleton

        content, default = still_page(skeleton(machine)), ""
    else:
        from ..view.scene import slide
        from ..view.skeletons import skeleton

        slide(
            skeleton(machine), lambda url: typer.echo(f"{machine} at {url}; Escape there ends it")
        )
        return
    path = out or Path("out") / default
    output_folder(path.parent)
    write_whole(path, content)
    typer.echo(path)


def _replay(machine: str, log: Path, run: str | None, magnify: float | None) -> str:
    from rich.console import Console

    from ..errors import InputError
    from ..gap.diagnosis import diagnose
    from ..gap.logset import load_logset
    from ..view.replay import page, replay

    logset = load_logset(log)
    if logset.kind.replace("_", "-") != machine:
        raise InputError(log, f"a log of system.kind {logset.kind}", f"one of {machine}")
    with Console(stderr=True).status("diagnosing") as status:
        return page(replay(diagnose(logset, progress=status.update), run, magnify))


def _blocks(machine: str) -> str:
    from ..errors import InputError
    from ..view.block_diagram import svg

    if machine == "c-drive":
        from ...diagrams.c_drive_config import CDriveLoopConfig
        from ...diagrams.c_drive_loop import c_drive_loop

        return svg(c_drive_loop(CDriveLoopConfig()))
    if machine == "pmc":
        from ...diagrams.pmc_loop import PMCLoopConfig, pmc_loop

        return svg(pmc_loop(PMCLoopConfig()))
    raise InputError("view --blocks", f"no loop of {machine!r}", "c-drive or pmc")
