"""Step-counting runs: one joint driven from one stop to another while its steps are counted.

The table (CSV) that ``gapscope calibrate mm3a`` reads has one row per run:

| column | unit | |
|---|---|---|
| day                | any label | runs of one label share their environment |
| joint              | 1, 2, 3 | the joint that moves |
| direction          | -1, 1 | |
| q1, q2, q3         | rad, rad, m | joints at the start |
| target             | rad or m | where the moving joint stops |
| theta, psi         | rad | tilt of the base (section 4.1.1) |
| steps              | | as counted by the audio limit switch |
"""

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...models.mm3a import kinematics, step_size
from ...models.mm3a.arm import Arm, gravity_in_base
from ...models.mm3a.limit_switch import LOOP
from ..errors import InputError
from ..files import write_whole

NODES, WEIGHTS = np.polynomial.legendre.leggauss(24)
NO_FORCE = (0.0, 0.0, 0.0)


@dataclass(frozen=True, kw_only=True)
class Run:
    """One row of the table, checked; ``posture`` and ``loads`` follow the moving joint."""

    day: str
    joint: int  # 1, 2 or 3
    direction: int  # -1 or 1
    q1: float  # at the start [rad]
    q2: float  # at the start [rad]
    q3: float  # at the start [m]
    target: float  # of the moving joint [rad or m]
    theta: float  # [rad]
    psi: float  # [rad]
    steps: int

    def __post_init__(self) -> None:
        if self.joint not in (1, 2, 3) or self.direction not in (-1, 1):
            raise ValueError(
                f"joint {self.joint}, direction {self.direction}; expected joint 1, 2 or 3 and "
                "direction -1 or 1"
            )
        if not (self.target - self.start) * self.direction > 0.0:
            raise ValueError(
                f"joint {self.joint} goes from {self.start} to {self.target} in direction "
                f"{self.direction}; expected the target on that side"
            )
        if not self.steps > LOOP:
            raise ValueError(f"{self.steps} steps; expected more than the {LOOP} of one recording")

    @property
    def start(self) -> float:
        """Where the moving joint starts [rad or m]."""
        return (self.q1, self.q2, self.q3)[self.joint - 1]

    @property
    def distance(self) -> float:
        """Length of the run, positive [rad or m]."""
        return abs(self.target - self.start)

    @property
    def mean_step(self) -> float:
        """Counted mean step [rad or m], less the half recording by which the count is long."""
        return self.distance / (self.steps - 0.5 * LOOP)

    def postures(self) -> NDArray[np.float64]:
        """Joints at the Gauss-Legendre nodes along the run, (nodes, 3)."""
        along = np.tile([self.q1, self.q2, self.q3], (NODES.size, 1))
        along[:, self.joint - 1] = self.start + 0.5 * (NODES + 1.0) * (self.target - self.start)
        return along

    def loads(self, arm: Arm) -> NDArray[np.float64]:
        """Load factor of the moving joint at ``postures``."""
        gravity = gravity_in_base(self.theta, self.psi)
        return np.array(
            [
                step_size.load_factors(q, gravity, NO_FORCE, arm)[self.joint - 1]
                for q in self.postures()
            ]
        )

    def check(self, arm: Arm) -> None:
        """Raise ValueError if the run leaves the joint limits of ``arm``."""
        ends = np.array([[self.q1, self.q2, self.q3]] * 2)
        ends[1, self.joint - 1] = self.target
        slack = 1e-9
        if not all(
            kinematics.within_limits(np.clip(q, arm.lower, arm.upper), arm)
            and np.all(np.abs(q - np.clip(q, arm.lower, arm.upper)) < slack)
            for q in ends
        ):
            raise ValueError(
                f"run from {tuple(ends[0])} to {self.target} leaves the joint limits {arm.lower} to "
                f"{arm.upper}"
            )


def mean_of_inverse(sizes: NDArray[np.float64]) -> float:
    """Mean step over a run, R / integral(dq/size), from the sizes at its nodes."""
    return 2.0 / float(np.sum(WEIGHTS / sizes))


COLUMNS = [field.name for field in fields(Run)]


def read_runs(path: Path, arm: Arm | None = None) -> list[Run]:
    """Runs of a CSV file. InputError names file, line, what is wrong and what is expected."""
    if not path.is_file():
        raise InputError(path, "no such file", f"a CSV table with columns {', '.join(COLUMNS)}")
    try:
        with path.open(newline="", encoding="utf-8") as file:
            reader = csv.DictReader(file)
            missing = [name for name in COLUMNS if name not in (reader.fieldnames or [])]
            rows = [] if missing else list(reader)
    except (UnicodeDecodeError, OSError, csv.Error) as error:
        raise InputError(path, f"unreadable ({error})", "a CSV table in UTF-8") from None
    if missing:
        raise InputError(
            path, f"columns {', '.join(missing)} are missing", f"columns {', '.join(COLUMNS)}"
        )
    if not rows:
        raise InputError(path, "the table has no rows", "one row per run")
    return [_run(path, line, row, arm or Arm()) for line, row in enumerate(rows, start=2)]


def _run(path: Path, line: int, row: dict[str, str], arm: Arm) -> Run:
    kinds = {field.name: field.type for field in fields(Run)}
    try:
        values = {name: _number(kinds[name], row[name]) for name in COLUMNS}
        run = Run(**values)  # type: ignore[arg-type]
        run.check(arm)
    except (TypeError, ValueError, OverflowError) as error:
        raise InputError(
            f"{path}, line {line}",
            str(error),
            "a run as described in gapscope.analysis.mm3a.runs",
            "Angles are in rad, lengths in m.",
        ) from error
    return run


def _number(kind: object, text: str | None) -> str | int | float:
    if text is None:
        raise ValueError("the row is shorter than the header")
    if kind is str:
        return text
    value = float(text)
    if not np.isfinite(value):
        raise ValueError(f"{text!r} is not a finite number")
    if kind is int:
        if value != int(value):
            raise ValueError(f"{text!r} is not a whole number")
        return int(value)
    return value


def write_runs(path: Path, runs: Iterable[Run]) -> None:
    """Write the table, complete or not at all."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(COLUMNS)
    for run in runs:
        writer.writerow([getattr(run, name) for name in COLUMNS])
    write_whole(path, text.getvalue())


def groups(runs: Sequence[Run]) -> dict[tuple[int, int], list[Run]]:
    """Runs by (joint, direction), in this order."""
    found = sorted({(run.joint, run.direction) for run in runs})
    return {key: [run for run in runs if (run.joint, run.direction) == key] for key in found}
