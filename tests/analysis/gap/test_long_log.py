"""A log too long to be held in memory is read as stretches, in memory that does not grow with it."""

import subprocess
import sys

import numpy as np
import pytest
import yaml

from .conftest import description

ROWS = 4_000_000  # 224 MB of numbers; the study of 36 million rows differs in nothing else
CODE = """
import resource, sys
from gapscope.analysis.gap.logset import load_logset
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
log = load_logset(sys.argv[1])
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(len(log.runs), sum(run.samples for run in log.runs), (after - before) // 1024, log.notes[0])
"""


@pytest.mark.slow
def test_memory_is_bounded_by_blocks_not_by_the_log(tmp_path):
    arrow = pytest.importorskip("pyarrow")
    parquet = pytest.importorskip("pyarrow.parquet")
    names = list(description()["columns"])
    part = 400_000
    with parquet.ParquetWriter(
        tmp_path / "run.parquet", arrow.schema([(n, arrow.float64()) for n in names])
    ) as writer:
        for first in range(0, ROWS, part):
            t = 1e-3 * (first + np.arange(part))
            columns = {n: np.sin((i + 1.0) * t) for i, n in enumerate(names)}
            writer.write_table(arrow.table({**columns, "t": t}))
    document = description()
    document["runs"] = [{"file": "run.parquet", "use": "fit", "controller": "pd"}]
    (tmp_path / "logset.yaml").write_text(yaml.safe_dump(document))
    done = subprocess.run(
        [sys.executable, "-c", CODE, str(tmp_path)], capture_output=True, text=True, check=True
    )
    runs, samples, grown, note = done.stdout.split(" ", 3)
    assert (int(runs), int(samples)) == (10, 50_000)
    assert int(grown) < 200  # MB; the whole table is 224 MB
    assert "4000000 rows" in note
