"""``gapscope simulate mm3a --moves``: a log set of moves by either truth, with chosen effects."""

from collections.abc import Sequence
from pathlib import Path

from ..errors import InputError
from . import empirical_moves
from .moves import diagnosis_plan, perform, write_logset

SCATTER = 0.003  # of a move, relative; the thesis prints none


def write(folder: Path, truth: str, effects: Sequence[str], seed: int) -> list[Path]:
    """Write the log set; returns its files. InputError for an unknown truth or effect."""
    if truth == "physical":
        return _physical(folder, effects, seed)
    if truth != "empirical":
        raise InputError("--truth", f"unknown truth {truth!r}", "empirical or physical")
    planted = empirical_moves.plant(*effects)
    plan = diagnosis_plan()
    mover = empirical_moves.EmpiricalMover(planted)
    tables = perform(plan, mover, scatter=SCATTER, seed=seed)
    return write_logset(folder, plan, tables, planted.nominal())


def _physical(folder: Path, effects: Sequence[str], seed: int) -> list[Path]:
    """As a blind case, but open: scatter and sizes of the effects are drawn with the seed."""
    from .blind import drawn, write_moves

    return write_moves(drawn(tuple(effects), seed), seed, folder)[0]
