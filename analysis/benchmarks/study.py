"""Which groups there are, and how many rounds each takes."""

import os
from pathlib import Path

from ..datasets import VARIABLE
from ..errors import InputError
from . import (
    closed_loop,
    diagnosis,
    first_diagnosis,
    growth,
    mechanisms,
    monte_carlo,
    one_fit,
    start_up,
)
from .rounds import Group

ROUNDS = {  # full, quick
    closed_loop.NAME: (31, 5),
    monte_carlo.NAME: (5, 3),
    mechanisms.NAME: (11, 3),
    growth.NAME: (11, 3),
    start_up.NAME: (31, 5),
    first_diagnosis.NAME: (3, 1),
    one_fit.NAME: (3, 1),
    diagnosis.NAME: (3, 1),
}


def measured(name: str, quick: bool, open_sets: Path | None, sets: int | None = None) -> Group:
    """Measure the group ``name``, with ``sets`` parameter sets in ``monte-carlo``.

    InputError if ``open_sets`` is stated and holds no log set.
    """
    rounds = ROUNDS[name][quick]
    if name == closed_loop.NAME:
        return closed_loop.closed_loop(rounds)
    if name == monte_carlo.NAME:
        usual = monte_carlo.QUICK_SETS if quick else monte_carlo.SETS
        return monte_carlo.monte_carlo(rounds, sets or usual)
    if name == mechanisms.NAME:
        return mechanisms.mechanisms(rounds)
    if name == growth.NAME:
        return growth.growth(rounds)
    if name == start_up.NAME:
        return start_up.start_up(rounds)
    if open_sets is not None and not diagnosis.log_sets(open_sets):
        raise InputError("--open", f"no log sets in {open_sets}", "a folder of log set folders")
    if name == first_diagnosis.NAME:
        return first_diagnosis.first_diagnosis(open_sets or default_folder(), rounds)
    if name == one_fit.NAME:
        return one_fit.one_fit(open_sets or default_folder(), rounds)
    return diagnosis.diagnosis(open_sets or default_folder(), rounds)


def default_folder() -> Path | None:
    """``gap/open`` beside the folder of measured data, if that is set."""
    data = os.environ.get(VARIABLE)
    return Path(data).resolve().parent / "gap" / "open" if data else None
