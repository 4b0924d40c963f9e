"""A second, independent machine: writes log sets whose answers are known and withheld.

It shares no code, coordinates, integrator, step or friction form with the models and hypotheses of
this toolbox (a test holds it to that), so a diagnosis cannot succeed by repeating its own mistakes.

    from gapscope.analysis.blind_machine import write_cases
    answers = write_cases(seed=1, count=40, directory=Path("tuning"))

Seeds below 1000 are for tuning an instrument, seeds from 1000 for reporting on it.
"""

from pathlib import Path
from typing import Any

from . import logset, strength
from .case import Case
from .cases import draw

__all__ = ["REPORT_SEEDS_FROM", "Case", "draw", "write_case", "write_cases"]

REPORT_SEEDS_FROM = 1000


def write_case(seed: int, index: int, directory: Path) -> dict[str, Any]:
    """Write case ``index`` of ``seed`` as a log set into ``directory``; return its answer.

    The answer holds the ids, causes, drawn parameters and ``strength`` of the whole and, for pairs,
    of each effect (the change when it alone is taken away), in multiples of the floor.
    """
    case = draw(seed, index)
    tables = logset.simulate(case, case.machine)
    logset.write(case, tables, directory)
    without = logset.simulate(case, case.nominal, events=False)
    parts = {
        cause: strength.strength(tables, logset.simulate(case, machine))
        for cause, machine in case.partial.items()
    }
    return {
        "name": case.name,
        "seed": seed,
        "index": index,
        "machine": "c_drive",
        "kind": case.kind,
        "answer": list(case.answer),
        "cause": list(case.cause),
        "parameters": dict(case.parameters),
        "strength": {"all": strength.strength(tables, without), **parts},
        "floor": strength.floor(without).tolist(),
        "nuisance": _differences(case),
        "speed": case.speed,
        "encoder_noise_rad": case.encoder_noise,
        "torque_noise_Nm": case.torque_noise,
    }


def write_cases(seed: int, count: int, directory: Path) -> list[dict[str, Any]]:
    """Write cases 0 to ``count`` - 1 into ``directory``/case_0000 and so on; return the answers."""
    return [write_case(seed, i, directory / f"case_{i:04d}") for i in range(count)]


def _differences(case: Case) -> dict[str, float]:
    nominal, jittered = type(case.nominal)()._asdict(), case.nominal._asdict()
    return {
        name: value / nominal[name] - 1 if isinstance(value, float) else 0.0
        for name, value in jittered.items()
        if name in ("mass", "turning_inertia", "rotor_inertia", "gamma")
    }
