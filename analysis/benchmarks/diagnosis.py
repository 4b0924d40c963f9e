"""Group ``diagnosis``: whole diagnoses of log sets, all hypotheses, with seconds and simulations each."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from .rounds import Contender, Group, Skipped, measure, rows

NAME = "diagnosis"
TASK = "read a log set, fit and rank all hypotheses, verdict and shrinkage; reports not written"


def log_sets(folder: Path) -> list[Path]:
    """The log sets directly in ``folder``, by name; none where there is no such folder."""
    return sorted(path.parent for path in folder.glob("*/logset.yaml"))


def diagnosis(folder: Path | None, rounds: int) -> Group:
    """Time the diagnosis of every log set in ``folder`` over ``rounds`` interleaved rounds.

    The first, untimed diagnosis loads or compiles the kernels. Answers of the sets are not read.
    """
    sets = log_sets(folder) if folder else []
    contenders = [Contender(name=path.name, run=_diagnose(path)) for path in sets]
    found: list[list[dict[str, Any]]] = [[] for _ in contenders]
    noted = [_noting(contender, notes) for contender, notes in zip(contenders, found)]
    seconds, repeats = measure(noted, rounds)
    checks = [_check(notes, float(np.median(times))) for notes, times in zip(found, seconds.T)]
    skipped = () if sets else (Skipped(name="open sets", reason=_missing(folder)),)
    return Group(
        name=NAME,
        task=TASK,
        rounds=rounds,
        reference=None,
        agreement="every repetition gives the same verdict, effects and count of simulations",
        rows=rows(noted, seconds, repeats, checks, None),
        skipped=skipped,
    )


def _missing(folder: Path | None) -> str:
    if folder is None:
        return "no folder of log sets; give --open DIR or set GAPSCOPE_DATA"
    return f"no log sets in {folder}; give --open DIR"


def _diagnose(path: Path) -> Callable[[], dict[str, Any]]:
    from ..gap.diagnosis import diagnose

    return lambda: diagnose(str(path)).to_json()


def _noting(contender: Contender, notes: list[dict[str, Any]]) -> Contender:
    """The same contender, whose results are kept as far as the check needs them."""

    def run() -> None:
        result = contender.run()
        notes.append(
            {
                "verdict": result["verdict"],
                "effects": [effect["id"] for effect in result["effects"]],
                "simulations": result["provenance"]["simulations"],
            }
        )

    return Contender(name=contender.name, run=run)


def _check(notes: list[dict[str, Any]], seconds: float) -> tuple[str, bool]:
    first = notes[0]
    rate = first["simulations"] / seconds
    words = " ".join([first["verdict"], *first["effects"]])
    return (
        f"{words}; {first['simulations']} simulations, {rate:.0f}/s",
        all(note == first for note in notes),
    )
