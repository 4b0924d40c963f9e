"""Group ``first-diagnosis``: ``gapscope diagnose`` in a new process, with and without compiled kernels on the disk."""

import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np

from .rounds import Contender, Group, Skipped, measure, rows

NAME = "first-diagnosis"
SET = "none"
COLD, WARM = "cold, kernels compiled", "warm, kernels on the disk"
_MAIN = "from gapscope.analysis.cli import main; main()"


def first_diagnosis(folder: Path | None, rounds: int) -> Group:
    """Time whole processes, reports written, over ``rounds`` interleaved rounds; skipped without the open set.

    Both keep their kernels in folders of their own, not in the user's: the cold one begins with an empty one.
    """
    path = folder / SET if folder else None
    contenders, skipped = [], []
    with tempfile.TemporaryDirectory(prefix="gapscope-bench-") as scratch:
        if path is None or not (path / "logset.yaml").is_file():
            reason = f"no log set {SET} in {folder}; give --open DIR or set GAPSCOPE_DATA"
            skipped.append(Skipped(name="log set", reason=reason))
        else:
            contenders = [
                Contender(name=COLD, run=_process(path, Path(scratch), cold=True)),
                Contender(name=WARM, run=_process(path, Path(scratch), cold=False)),
            ]
        codes: dict[str, list[int]] = {one.name: [] for one in contenders}
        noting = [_noting(one, codes[one.name]) for one in contenders]
        seconds, repeats = measure(noting, rounds) if noting else (np.zeros((rounds, 0)), [])
        checks = [(f"exit codes {sorted(set(found))}", not any(found)) for found in codes.values()]
        return Group(
            name=NAME,
            task=f"a new process diagnoses the open set {SET!r} and writes its report",
            rounds=rounds,
            reference=WARM if noting else None,
            agreement="exit code 0",
            rows=rows(noting, seconds, repeats, checks, WARM),
            skipped=tuple(skipped),
        )


def _noting(contender: Contender, codes: list[int]) -> Contender:
    return Contender(name=contender.name, run=lambda: codes.append(contender.run()))


def _process(path: Path, scratch: Path, cold: bool) -> Callable[[], int]:
    def run() -> int:
        cache = tempfile.mkdtemp(dir=scratch) if cold else str(scratch / "warm")
        out = tempfile.mkdtemp(dir=scratch)
        return subprocess.run(
            [sys.executable, "-c", _MAIN, "diagnose", str(path), "--out", out],
            env={**os.environ, "NUMBA_CACHE_DIR": cache},
            capture_output=True,
        ).returncode

    return run
