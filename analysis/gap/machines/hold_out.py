"""Runs kept out of fitting where a log set marks none for validation."""

from collections.abc import Sequence
from dataclasses import replace
from typing import TypeVar

from ..machine import RunData

EVERY = 4  # every fourth run is held back
FEWEST = 6  # runs from which on whole runs can be spared

R = TypeVar("R", bound=RunData)


def hold_back_runs(runs: Sequence[R]) -> list[R]:
    """The runs, every fourth of them marked ``validate`` if none is and six at least are there.

    Whole runs rather than the ends of all: a motion that ends at rest would be judged on nothing.
    The rule looks at the order of the runs only, never at their content.
    """
    if len(runs) < FEWEST or any(run.use == "validate" for run in runs):
        return list(runs)
    return [
        replace(run, use="validate") if i % EVERY == EVERY - 1 else run
        for i, run in enumerate(runs)
    ]
