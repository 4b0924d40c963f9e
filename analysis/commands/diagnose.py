"""``gapscope diagnose LOGSET``: where the gap is, what causes it, how far it shrinks."""

from pathlib import Path
from typing import Annotated

import typer

from . import places


def diagnose(
    logset: Annotated[str, typer.Argument(help="A log set folder, or `thesis-c-drive`.")],
    out: Annotated[
        Path | None,
        typer.Option(
            callback=places.folder,
            help="Folder for diagnosis.json and report.html; default out/NAME.",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(help="Seed of the bootstrap.")] = 0,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress, no table.")] = False,
) -> None:
    """Diagnose the gap between a log set and its nominal model."""
    folder = out or Path("out") / (Path(logset).resolve().name or "diagnosis")
    places.folder(folder)
    paths = (_thesis if logset == "thesis-c-drive" else _logset)(logset, folder, seed, quiet)
    if not quiet:
        for path in paths:
            typer.echo(path)


def _logset(logset: str, out: Path, seed: int, quiet: bool) -> list[Path]:
    from rich.console import Console

    from ..gap.diagnosis import diagnose
    from ..gap.report import write_report
    from ..gap.terminal import print_diagnosis

    with Console(stderr=True, quiet=quiet).status("reading") as status:
        result = diagnose(logset, seed=seed, progress=status.update)
    if not quiet:
        print_diagnosis(Console(), result)
    return [result.save(out), write_report(result, out)]


def _thesis(name: str, out: Path, seed: int, quiet: bool) -> list[Path]:
    """The printed experiment of the thesis, from its tables."""
    from rich.console import Console

    from ..gap.thesis.diagnosis import diagnose_thesis
    from ..gap.thesis.terminal import print_thesis

    with Console(stderr=True, quiet=quiet).status("reading") as status:
        result = diagnose_thesis(seed=seed, progress=status.update)
    if not quiet:
        print_thesis(Console(), result)
    return list(result.save(out))
