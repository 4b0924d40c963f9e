"""kill -9 at random moments of a sweep loses no finished case and leaves no half file."""

import json
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

CASES = [{"x": x} for x in range(40)]
SWEEP = """
import sys
from pathlib import Path
sys.path.insert(0, {here!r})
import test_kill
from gapscope.analysis.resumable import resumable_map
resumable_map(test_kill.slow, test_kill.CASES, Path({folder!r}))
"""


def slow(x):
    """A case whose result takes long enough to write that a kill can fall into it."""
    time.sleep(0.002)
    rng = random.Random(x)
    return {"x": x, "values": [rng.random() for _ in range(20_000)]}


def finished(folder):
    """Results on disk; every file must be whole."""
    return {path.name: json.loads(path.read_text()) for path in folder.glob("[!.]*")}


def test_kills_cost_nothing_that_was_finished(tmp_path):
    folder = tmp_path / "sweep"
    code = SWEEP.format(here=str(Path(__file__).parent), folder=str(folder))
    rng, before, kills = random.Random(3), {}, 0
    while len(before) < len(CASES) - 8:
        sweep = subprocess.Popen([sys.executable, "-c", code])
        more = len(before) + rng.randint(
            1, 8
        )  # the moment is told by progress, so that load is no matter
        while sweep.poll() is None and len(list(folder.glob("[!.]*"))) < more:
            time.sleep(0.002)
        time.sleep(rng.uniform(0.0, 0.02))
        kills += sweep.poll() is None
        sweep.kill()
        assert sweep.wait() in (0, -signal.SIGKILL)
        after = finished(folder)
        assert before.items() <= after.items()
        before = after
    assert kills >= 2
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert sorted(v["x"] for v in finished(folder).values()) == [c["x"] for c in CASES]
    assert [p.name for p in folder.iterdir() if p.name.startswith(".")] == []
