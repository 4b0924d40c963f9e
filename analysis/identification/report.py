"""Files and terminal summary of an identification."""

import json
from pathlib import Path

import numpy as np

from ...models.parallel import sdf
from ..files import write_folder
from . import figures
from .study import Study, findings


def write(study: Study, out: Path) -> list[Path]:
    """identification.json, figures, and the feasible machine as SDF with its closures."""
    m = study.machine
    chain = m.chain(study.feasible[: len(m.parameters)])
    coulomb, viscous = (
        dict(zip(chain.driven, part.tolist()))
        for part in np.split(study.feasible[len(m.parameters) :], 2)
    )
    text = json.dumps(_plain(findings(study)), indent=1, allow_nan=False) + "\n"
    return write_folder(
        out,
        {
            "identification.json": lambda path: path.write_text(text),
            f"{m.name}.sdf": lambda path: path.write_text(sdf.sdf(chain, viscous, coulomb)),
            "closures.yaml": lambda path: path.write_text(sdf.closures(chain)),
            **figures.writers(study),
        },
    )


def summarise(study: Study) -> None:
    """Print what was found."""
    from rich.console import Console
    from rich.table import Table

    console, found = Console(), findings(study)
    table = Table("search", "condition number", "evaluations", "printed")
    for s in study.searches:
        printed = study.machine.printed.get("condition", {}).get(s.method)
        table.add_row(s.method, f"{s.condition:.2f}", str(s.evaluations), str(printed or ""))
    console.print(table)
    rows = Table("base parameter", "planted", "estimate", "± 95 %")
    for row in found["base_parameters"]["rows"]:
        rows.add_row(
            row["sum"],
            f"{row['planted']:.4g}",
            f"{row['estimate']:.4g}",
            f"{row['half_width_95']:.2g}",
        )
    console.print(rows)
    held = found["intervals"]
    if held["repeats"]:
        console.print(
            f"intervals held the planted value in {held['held']} of {held['of']} "
            f"({held['repeats']} repetitions of the noise)"
        )
    errors = ", ".join(f"{name} {1e2 * value:.1f} %" for name, value in study.errors.items())
    console.print(f"force error on another motion: {errors}")


def _plain(value):  # type: ignore[no-untyped-def]
    """Numbers without numpy types, and null for what is not finite."""
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    if isinstance(value, np.integer):
        return int(value)
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
