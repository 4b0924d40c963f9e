"""A second, independent machine: writes log sets whose answers are known and withheld.

It shares no code, coordinates, integrator, step or friction form with the models and hypotheses of
this toolbox (a test holds it to that), so a diagnosis cannot succeed by repeating its own mistakes.

    from gapscope.analysis.blind_machine import write_cases
    answers = write_cases(seed=1, count=40, directory=Path("tuning"))

Seeds below 1000 are for tuning an instrument, seeds from 1000 for reporting on it.
"""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from . import logset, strength
from .case import Case, case_name
from .cases import draw

__all__ = ["REPORT_SEEDS_FROM", "Case", "case_name", "draw", "write_case", "write_cases"]

REPORT_SEEDS_FROM = 1000
FINE_LSB = 1e-9  # rad or m: an encoder that does not count


def write_case(seed: int, index: int, directory: Path) -> dict[str, Any]:
    """Write case ``index`` of ``seed`` as a log set into ``directory``; return its answer.

    The answer holds the ids, causes, drawn parameters and ``strength`` of the whole and, for pairs,
    of each effect (the change when it alone is taken away), in multiples of the floor on the runs
    to fit.
    """
    case = draw(seed, index)
    tables = logset.simulate(case, case.machine)
    logset.write(case, tables, directory)
    without = logset.simulate(case, case.nominal, events=False)
    signals, seen = logset.layout(case).SIGNALS, logset.runs_for(case, "fit")
    parts = {
        cause: strength.strength(tables, logset.simulate(case, machine), seen, signals)
        for cause, machine in case.partial.items()
    }
    return {
        "name": case.name,
        "seed": seed,
        "index": index,
        "machine": logset.layout(case).description(case)["system"]["kind"],
        "kind": case.kind,
        "answer": list(case.answer),
        "cause": list(case.cause),
        "parameters": dict(case.parameters),
        "strength": {"all": strength.strength(tables, without, seen, signals), **parts},
        "attainable_percent": _attainable(case, tables),
        "floor": strength.floor(without, signals).tolist(),
        "nuisance": _differences(case),
        "speed": case.speed,
        "soft_controllers": case.soft,
        "encoder_noise": case.encoder_noise,
        "torque_noise_Nm": case.torque_noise,
    }


def write_cases(seed: int, count: int, directory: Path) -> list[dict[str, Any]]:
    """Write cases 0 to ``count`` - 1 into ``directory``/case_0000 and so on; return the answers."""
    return [write_case(seed, i, directory / case_name(i)) for i in range(count)]


def _attainable(case: Case, tables: list[strength.Array]) -> float | None:
    """Share of the gap that the true machine's own model removes, on the validation runs [%].

    Model outputs are free of encoder counts and noise, as an instrument's are; ``before`` is the
    stated machine, ``after`` the machine that made the log, ``floor`` its repeatability. None
    where the whole gap is below twice the floor and a share of it means nothing.
    """
    ideal = replace(case, encoder_noise=0.0, torque_noise=0.0)
    stated = type(case.machine)()
    coarse = case.machine.lsb != stated.lsb  # then the counts are the effect
    models = [
        machine._replace(lsb=machine.lsb if coarse else FINE_LSB)
        for machine in (stated, case.machine)
    ]
    runs, signals = logset.runs_for(case, "validate"), logset.layout(case).SIGNALS
    before, after = (
        strength.gap(tables, logset.simulate(ideal, m, events=m is models[1]), runs, signals)
        for m in models
    )
    return 100 * (before - after) / (before - 1.0) if before > 2.0 else None


def _differences(case: Case) -> dict[str, Any]:
    """Relative nuisance of every parameter that has one."""
    stated, jittered = type(case.nominal)()._asdict(), case.nominal._asdict()
    return {
        name: (np.divide(value, stated[name]) - 1).tolist()
        for name, value in jittered.items()
        if value != stated[name]
    }
