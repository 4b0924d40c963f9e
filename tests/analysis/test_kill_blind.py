"""kill -9 of ``gapscope blind`` at random moments costs no finished case, and the end is the same."""

import contextlib
import json
import os
import random
import signal
import subprocess
import sys
import time

import pytest

from .blind_runs import outcome

BLIND = """
import sys
from gapscope.analysis import cli
sys.argv[1:] = ["blind", "--seed", "11", "--cases", "3", "--out", {folder!r}, "--workers", "{workers}"]
cli.main()
"""


def start_blind(folder, workers):
    """``gapscope blind`` on three cases, with a process group of its own; what it says goes beside the folder."""
    with open(folder.with_suffix(".txt"), "w", encoding="utf-8") as said:
        return subprocess.Popen(
            [sys.executable, "-c", BLIND.format(folder=str(folder), workers=workers)],
            stdout=said, stderr=subprocess.STDOUT, start_new_session=True,
        )  # fmt: skip


def ended_well(run, folder):
    assert run.wait() == 0, folder.with_suffix(".txt").read_text()


def finished(folder):
    """Cases written and cases diagnosed."""
    return len(list(folder.glob("answers/[!.]*"))) + len(list(folder.glob("results/[!.]*")))


def whole_files(folder):
    """Every file with its place in the run is whole; bytes by name."""
    found = {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    kept = {p: data for p, data in found.items() if not any(x.startswith(".") for x in p.parts)}
    for path, data in kept.items():
        if path.suffix == ".json":
            json.loads(data)
        if path.suffix == ".html":
            assert data.rstrip().endswith(b"</html>")
    return kept


@pytest.mark.slow
def test_a_blind_run_killed_at_random_moments_ends_as_one_that_was_not(tmp_path):
    alone, folder = tmp_path / "alone", tmp_path / "killed"
    ended_well(start_blind(alone, 1), alone)
    rng, kept, kills = random.Random(5), {}, 0
    while len(kept) < finished(alone) - 1:
        run = start_blind(folder, 1 + kills % 2)
        more = len(kept) + rng.randint(1, 2)  # progress tells the moment, so that load is no matter
        while run.poll() is None and finished(folder) < more:
            time.sleep(0.01)
        time.sleep(rng.uniform(0.0, 3.0))
        kills += run.poll() is None
        with contextlib.suppress(ProcessLookupError):
            os.killpg(run.pid, signal.SIGKILL)
        assert run.wait() in (0, -signal.SIGKILL), folder.with_suffix(".txt").read_text()
        found = whole_files(folder)
        assert [p for p in kept if found.get(p) != kept[p]] == []
        kept = {p: data for p, data in found.items() if p.parts[0] in ("answers", "results")}
    assert kills >= 2
    ended_well(start_blind(folder, 2), folder)
    assert outcome(folder) == outcome(alone)
    assert list(folder.rglob(".*")) == []
