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

    from ..gap.diagnosis import diagnose as run
    from ..gap.report import write_report
    from ..gap.terminal import print_diagnosis

    console = Console(stderr=True, quiet=quiet)
    with console.status("reading") as status:
        result = run(logset, seed=seed, progress=lambda text: status.update(text))
    result.save(out)
    report = write_report(result, out)
    if not quiet:
        print_diagnosis(Console(), result)
        Console().print(f"report: {report}", highlight=False, markup=False, soft_wrap=True)
