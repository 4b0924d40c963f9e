"""``gapscope diagnose LOGSET``: where the gap is, what causes it, how far it shrinks."""

from pathlib import Path
from typing import Annotated

import typer


def diagnose(
    logset: Annotated[str, typer.Argument(help="A log set folder, or `thesis-c-drive`.")],
    out: Annotated[Path, typer.Option(help="Folder for diagnosis.json and report.html.")],
    seed: Annotated[int, typer.Option(help="Seed of the bootstrap.")] = 0,
    quiet: Annotated[bool, typer.Option("--quiet", help="No progress, no table.")] = False,
) -> None:
    """Diagnose the gap between a log set and its nominal model."""
    from rich.console import Console

    if logset == "thesis-c-drive":
        return _thesis(out, seed, quiet)
    from ..gap.diagnosis import diagnose as run
    from ..gap.terminal import print_diagnosis

    console = Console(stderr=True, quiet=quiet)
    with console.status("reading") as status:
        result = run(logset, seed=seed, progress=lambda text: status.update(text))
    result.save(out)
    if not quiet:
        print_diagnosis(Console(), result)


def _thesis(out: Path, seed: int, quiet: bool) -> None:
    """The printed experiment of the thesis, from its tables."""
    from rich.console import Console

    from ..gap.thesis.diagnosis import diagnose_thesis
    from ..gap.thesis.terminal import print_thesis

    with Console(stderr=True, quiet=quiet).status("reading") as status:
        result = diagnose_thesis(seed=seed, progress=lambda text: status.update(text))
    paths = result.save(out)
    if not quiet:
        print_thesis(Console(), result)
        for path in paths:
            typer.echo(path)
