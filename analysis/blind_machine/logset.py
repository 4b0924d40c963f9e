"""Runs a case on the machine it was drawn for and writes its log set."""

from pathlib import Path
from types import ModuleType

import numpy as np
import yaml

from . import drive_logset, slider_logset
from .case import AnyMachine, Case
from .motion import Array
from .slider import Slider


def layout(case: Case) -> ModuleType:
    """The module that runs and describes this kind of machine."""
    return slider_logset if isinstance(case.machine, Slider) else drive_logset


def simulate(case: Case, machine: AnyMachine, *, events: bool = True) -> list[Array]:
    """The logged tables of ``machine`` under the case's excitation and noise.

    ``events`` allows the knocks and lost commands that belong to the case's effect.
    """
    tables: list[Array] = layout(case).simulate(case, machine, events=events)
    return tables


def runs_for(case: Case, purpose: str) -> list[int]:
    """Numbers of the runs to ``fit``, or to ``validate``, which no instrument may fit."""
    return [i for i, (*_, use) in enumerate(layout(case).RUNS) if use == purpose]


def write(case: Case, tables: list[Array], directory: Path) -> None:
    """Write ``logset.yaml`` and the tables into ``directory`` (made if missing)."""
    directory.mkdir(parents=True, exist_ok=True)
    for number, table in enumerate(tables, 1):
        np.savetxt(
            directory / f"run{number}.csv",
            table,
            fmt=layout(case).FORMATS,
            delimiter=",",
            header=",".join(layout(case).COLUMNS),
            comments="",
        )
    text = yaml.safe_dump(layout(case).description(case), sort_keys=False)
    (directory / "logset.yaml").write_text(text)
