"""Where the numbers come from: versions, hashes, seed, effort and the runs."""

from typing import Any

from .base import Material, Section
from .words import percent

NAMES = {
    "gapscope": "gapscope version",
    "logset": "log set",
    "sha256": "SHA-256 of the log set",
    "seed": "seed of the bootstrap",
    "simulations": "predictions of a run",
    "seconds": "seconds",
}


def context(material: Material) -> dict[str, Any]:
    """The provenance of the diagnosis, its runs and its log set."""
    d = material.diagnosis
    disagreement = {check.run: check.disagreement for check in d.replays}
    runs = []
    for run in d.logset.runs:
        settings = {k: v for k, v in run.settings.items() if k != "note"}
        runs.append(
            {
                "name": run.name,
                "use": run.use if d.logset.validate else "split: beginning to fit, end to validate",
                "controller": run.controller,
                "settings": ", ".join(f"{k} {v}" for k, v in settings.items()),
                "samples": run.samples,
                "seconds": f"{run.samples * d.logset.dt:.3g}",
                "replay": percent(disagreement.get(run.name), 1),
            }
        )
    return {
        "pairs": [(NAMES.get(key, key), _text(value)) for key, value in d.provenance.items()],
        "runs": runs,
        "command": f"gapscope diagnose {d.logset.folder.name} --out FOLDER --seed "
        f"{d.provenance.get('seed', 0)}",
    }


def _text(value: Any) -> str:
    return f"{value:.1f}" if isinstance(value, float) else str(value)


SECTION = Section(key="provenance", title="Provenance", context=context)
