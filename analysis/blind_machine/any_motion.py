"""One run of the blind machine on a motion of the caller's, for experiments beyond the fixed six."""

from typing import Any

import numpy as np

from . import drive_logset
from .c_drive import Machine, Program, run
from .case import SINGLE, Case
from .controllers import Controller
from .drive_logset import COLUMNS
from .motion import Array

FORMATS = ["%.3f"] + ["%.9f"] * 4 + ["%.4f"] * 2


def table(
    machine: Machine,
    controller: Controller,
    t: Array,
    reference: Array,
    acceleration: Array,
    *,
    seed: int = 0,
    torque_noise: float = 0.002,
) -> Array:
    """Logged columns (n, 7) of one run from rest at zero; ``t`` (n,) in steps of 1 ms.

    ``reference`` [rad] and ``acceleration`` [rad/s^2] are (n, 2); ``torque_noise`` [Nm] is the log's.
    """
    n = len(t)
    program = Program(
        reference=np.ascontiguousarray(reference),
        acceleration=np.ascontiguousarray(acceleration),
        encoder_noise=np.zeros((n, 2)),
        dropped=np.zeros(n),
        kicks=np.zeros(n),
        start=0.0,
    )
    readings, commands, _ = run(machine, controller, program)
    noise = torque_noise * np.random.default_rng(seed).standard_normal((n, 2))
    return np.column_stack([t, reference, readings, commands + noise])


def csv(rows: Array) -> str:
    """The rows as the text of a log set's table."""
    lines = [",".join(f % v for f, v in zip(FORMATS, row)) for row in rows]
    return "\n".join([",".join(COLUMNS), *lines, ""])


def description(name: str, runs: list[dict[str, Any]]) -> dict[str, Any]:
    """The content of ``logset.yaml`` for these runs; it says nothing of what is hidden."""
    nominal = Machine()
    case = Case(
        seed=0, index=0, kind=SINGLE, answer=(), cause=(), nominal=nominal, machine=nominal, partial={}
    )  # fmt: skip
    return {**drive_logset.description(case), "name": name, "runs": runs}
