"""``gapscope workspace 5r | replalink | 2prr | mast | 3prs``."""

from pathlib import Path
from typing import Annotated

import typer

from . import places

Out = Annotated[
    Path, typer.Option(callback=places.folder, help="Folder for workspace.json and figures.")
]


def five_r(out: Out) -> None:
    """5R: joint space, workspace, working modes, dexterity (Fig. 4.2)."""
    _planar("5r", out)


def replalink(out: Out) -> None:
    """RePlaLink: joint space, workspace, working modes, dexterity (Fig. 6.14)."""
    _planar("replalink", out)


def two_prr(out: Out) -> None:
    """2-PRR: travel and workspace beside the printed rectangle (Fig. 6.1b)."""
    _planar("2prr", out)


def mast(out: Out) -> None:
    """2PRU-1PRS table: tilts at each height, parasitic motion."""
    from ..parallel import figures, tables

    result = tables.mast()
    _write(out, result.findings, {"tilts.png": figures.tilts(result)})


def three_prs(out: Out) -> None:
    """3-PRS table: tilts, printed requirement, forward kinematics beside measured poses."""
    from ..parallel import figures, tables

    result = tables.compliant()
    drawn = {"tilts.png": figures.tilts(result), "measured.png": figures.measured(result)}
    _write(out, result.findings, drawn)


COMMANDS = {
    "5r": five_r,
    "replalink": replalink,
    "2prr": two_prr,
    "mast": mast,
    "3prs": three_prs,
}


def _planar(name: str, out: Path) -> None:
    from ..parallel import figures, planar

    result = planar.slider_pair() if name == "2prr" else planar.linkage(name)
    _write(out, result.findings, {"workspace.png": figures.planar(result)})


def _write(out: Path, findings: dict, drawn: dict) -> None:
    import json

    from ..files import write_folder
    from ..parallel.figures import writer

    text = json.dumps(findings, indent=1, allow_nan=False) + "\n"
    files = {"workspace.json": lambda path: path.write_text(text)}
    files |= {name: writer(figure) for name, figure in drawn.items()}
    for path in write_folder(out, files):
        typer.echo(f"wrote {path}")
