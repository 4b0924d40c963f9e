"""Series of moves as a log set for ``gapscope diagnose``: who moves, from where, and what is written.

A series drives one joint forth and back from a list of postures and measures every move; it is one
run of the log set (``analysis/gap/machines/mm3a.py`` describes the columns). Whatever moves the
joints is a ``Mover``.
"""

import io
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import yaml
from numpy.typing import NDArray

from ...models.mm3a.arm import Arm
from ...models.mm3a.step_size import STEP_TIME
from ..files import output_folder, write_whole

COLUMNS = {"t": "s", "steps": "1", "q1": "rad", "q2": "rad", "q3": "m", "moved": "rad or m"}
PATTERN = (1, 1, -1, -1)  # directions of the moves of one repeat: every other one reverses
MEASURING = 4.0  # time to measure a move [s]
CHANGING = 60.0  # time between series [s]
LEVEL, HALF = -0.5 * np.pi, -0.5 * np.pi


@dataclass(frozen=True, kw_only=True)
class Series:
    """Moves of one joint, ``repeats`` times ``PATTERN`` with each number of steps at each posture."""

    joint: int  # 1, 2 or 3
    theta: float  # tilt of the base [rad]
    postures: tuple[tuple[float, float, float], ...]  # joints at the start [rad, rad, m]
    session: str
    use: str = "fit"  # or validate
    counts: tuple[int, ...] = (10, 30)  # steps of a move
    repeats: int = 2
    run_in: int = 0  # steps before every move, in its direction, that are not logged


class Mover(Protocol):
    """What moves the joints; it keeps its own memory of a session."""

    def begin(self, session: str) -> None:
        """A session begins, with everything at rest and cold."""

    def move(self, series: Series, q: NDArray[np.float64], steps: int, t: float) -> float:
        """True displacement [rad or m] of ``steps`` signed steps from joints ``q``, begun at ``t`` [s]."""


def diagnosis_plan(run_in: int = 0, sessions: Sequence[str] = ("day-1", "day-2")) -> list[Series]:
    """Joints 2 and 3, loaded and free, on two days; validation at tilts and postures of its own."""
    plan = []
    elbows, between = np.radians([-45, -68, -90, -112, -135]), np.radians([-56, -79, -101, -124])
    for session in sessions:
        for use, theta, angles in (
            ("fit", 0.0, elbows),
            ("fit", HALF, elbows),
            ("validate", -np.pi / 4, between),
        ):
            slide = tuple((0.0, float(a), 0.006) for a in angles)
            turn = tuple((0.0, float(a), q3) for q3 in (0.0, 0.012) for a in angles[::2])
            plan += [
                Series(
                    joint=j,
                    theta=theta,
                    postures=p,
                    session=session,
                    use=use,
                    run_in=run_in,
                    repeats=2 if run_in == 0 else 1,
                )
                for j, p in ((3, slide), (2, turn))
            ]
    return plan


def perform(
    plan: Sequence[Series], mover: Mover, *, scatter: float, seed: int
) -> list[NDArray[np.float64]]:
    """Tables (moves, 6) of every series, in the order of ``COLUMNS``.

    Every move has its own relative Gaussian ``scatter``. Series of one session follow one another.
    """
    rng = np.random.default_rng(seed)
    clock: dict[str, float] = {}
    tables = []
    for series in plan:
        if series.session not in clock:
            mover.begin(series.session)
        t = clock.get(series.session, 0.0) + CHANGING
        rows = []
        for posture in series.postures:
            q = np.array(posture)
            for steps in [c * d for c in series.counts for d in series.repeats * PATTERN]:
                true = mover.move(series, q, steps, t)
                rows.append([t, steps, *q, true * (1.0 + scatter * rng.standard_normal())])
                q[series.joint - 1] = _inside(q[series.joint - 1] + true, series.joint)
                t += (abs(steps) + series.run_in) * STEP_TIME + MEASURING
        clock[series.session] = t
        tables.append(np.array(rows))
    return tables


def _inside(value: float, joint: int) -> float:
    arm = Arm()
    return float(np.clip(value, arm.lower[joint - 1], arm.upper[joint - 1]))


def write_logset(
    folder: Path,
    plan: Sequence[Series],
    tables: Sequence[NDArray[np.float64]],
    nominal: Mapping[str, Any],
    name: str = "mm3a-moves",
) -> list[Path]:
    """Write ``logset.yaml`` and one table per series; returns the files."""
    target = output_folder(folder)
    runs, files = [], []
    for i, (series, table) in enumerate(zip(plan, tables), start=1):
        text = io.StringIO()
        np.savetxt(text, table, delimiter=",", header=",".join(COLUMNS), comments="", fmt="%.10g")
        files.append(target / f"run{i}.csv")
        write_whole(files[-1], text.getvalue())
        runs.append(
            {
                "file": files[-1].name,
                "joint": series.joint,
                "theta_rad": float(series.theta),
                "session": series.session,
                "run_in_steps": series.run_in,
                "use": series.use,
            }
        )
    description = {
        "format": 1,
        "name": name,
        "system": {"kind": "mm3a", "nominal": dict(nominal)},
        "columns": COLUMNS,
        "runs": runs,
    }
    files.insert(0, target / "logset.yaml")
    write_whole(files[0], yaml.safe_dump(description, sort_keys=False))
    return files
