"""Runs made ready for a diagnosis: what is held back, where they begin to count, one encoder for all."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .machine import Machine, RunData, encoder_step

HELD_BACK = 0.3  # share of a lone run's end that is kept for validation


def prepared(machine: Machine, runs: Sequence[RunData]) -> list[RunData]:
    """The runs of a log set as the pipeline needs them."""
    return _of_one_encoder([_settled(machine, run) for run in _with_validation(runs)])


def held_back(runs: Sequence[RunData]) -> str:
    """What was kept for validation although the log set marks nothing."""
    fitted = {run.name for run in runs if run.use == "fit"}
    whole = [run.name for run in runs if run.use == "validate" and run.name not in fitted]
    what = (
        f"{', '.join(whole)} were"
        if whole
        else f"the last {100 * HELD_BACK:.0f} % of every run were"
    )
    return f"No run is marked validate: {what} held back and used for shrinkage only."


def _with_validation(runs: Sequence[RunData]) -> list[RunData]:
    """The runs; where none is marked for validation, the end of each fit run is held back."""
    if any(run.use == "validate" for run in runs):
        return list(runs)
    split = []
    for run in runs:
        cut = int(len(run.t) * (1.0 - HELD_BACK))
        step = encoder_step(run.position[:cut]) if run.lsb > 0.0 else run.lsb
        split.append(replace(run, window=slice(0, cut), lsb=step))
        split.append(replace(run, use="validate", window=slice(cut, None), lsb=step))
    return split


def _settled(machine: Machine, run: RunData) -> RunData:
    """The run without the samples that only show what is not known of its first state."""
    first = max(run.window.start or 0, machine.settling(run))
    return replace(run, window=slice(first, run.window.stop))


def _of_one_encoder(runs: Sequence[RunData]) -> list[RunData]:
    """The runs, with the encoder's step that the fit runs show where a run shows none."""
    steps = [run.lsb for run in runs if run.use == "fit" and run.lsb > 0.0]
    step = float(np.median(steps)) if steps else 0.0
    return [run if run.lsb > 0.0 else replace(run, lsb=step) for run in runs]
