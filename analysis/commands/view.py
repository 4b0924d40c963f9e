"""``gapscope view MACHINE``: a machine with sliders, a log with ghosts; ``gapscope view DIAGRAM --blocks``."""

from pathlib import Path
from typing import Annotated

import typer

from . import places


def view(
    machine: Annotated[
        str,
        typer.Argument(
            help="c-drive, slider, pmc, mm3a, 5r, replalink, 2prr, mast, 3prs, furuta, pendulum, arm, or an .urdf or "
            ".sdf file. With --blocks: a diagram of the toolbox (a wrong name lists them), or FILE.py:FUNCTION, what that function of yours returns."
        ),
    ],
    log: Annotated[
        Path | None, typer.Option(help="Log set of it: replay a run beside its models.")
    ] = None,
    run: Annotated[
        str | None, typer.Option(help="Run of the log set; default the first held out that moves.")
    ] = None,
    magnify: Annotated[
        float | None, typer.Option(help="Enlarge differences of the models; default 5 % of motion.")
    ] = None,
    blocks: Annotated[
        bool, typer.Option("--blocks", help="Block diagram as SVG, instead.")
    ] = False,
    depth: Annotated[
        int, typer.Option(help="With --blocks: levels of subsystems that are opened.", min=0)
    ] = 1,
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
        from ..view.block_diagram import svg
        from ..view.diagrams import diagram

        content = svg(diagram(machine), depth=depth)
        default = f"{machine.rpartition(':')[2]}.svg"
    elif log is not None:
        content, default = _replay(machine, log, run, magnify), "replay.html"
    elif out is not None:
        from ..view.scene import still_page
        from ..view.skeletons import skeleton

        content, default = still_page(skeleton(machine)), "machine.html"
    else:
        from ..view.scene import slide
        from ..view.skeletons import skeleton

        slide(
            skeleton(machine),
            lambda url: typer.echo(
                f"{machine} at {url}; sliders under Open Controls, Escape there ends it"
            ),
        )
        return
    path = out or Path("out") / default
    if not path.suffix:  # browsers show a page without one as text
        path = path.with_suffix(Path(default).suffix)
    output_folder(path.parent)
    write_whole(path, content)
    typer.echo(path)


def _replay(machine: str, log: Path, run: str | None, magnify: float | None) -> str:
    from rich.console import Console

    from ..errors import InputError
    from ..gap.diagnosis import diagnose
    from ..gap.logset import load_logset
    from ..view.logged import NAMES
    from ..view.replay import page, replay

    logset = load_logset(log)
    name = NAMES.get(logset.kind, Path(str(logset.system.get("model", logset.kind))).name)
    if machine not in (name, logset.kind) and Path(machine).name != name:
        raise InputError(log, f"a log of {logset.kind}", f"one of {machine}", f"Try: view {name}")
    with Console(stderr=True).status("diagnosing") as status:
        return page(replay(diagnose(logset, progress=status.update), run, magnify))
