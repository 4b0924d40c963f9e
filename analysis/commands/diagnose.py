"""``gapscope diagnose LOGSET``: where the gap is, what causes it, how far it shrinks."""

from pathlib import Path
from typing import Annotated

import typer


def diagnose(
    logset: Annotated[str, typer.Argument(help="A log set folder, or `thesis-c-drive`.")],
    out: Annotated[Path, typer.Option(help="Folder for diagnosis.json and report.html.")],
) -> None:
    """Diagnose the gap between a log set and its nominal model."""
