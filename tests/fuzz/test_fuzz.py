"""Mutated inputs end in an answer or in one InputError; the long campaign is a study.

By hand: ``cd tests && python -m fuzz.campaign run COUNT FOLDER [FIRST]`` prints outcomes and failures,
``python -m fuzz.guided TARGET FOLDER SECONDS`` searches on, guided by coverage.
"""

import contextlib
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from gapscope.analysis.errors import InputError

from . import campaign, targets
from .mutation import BOMB, mutated

pytest.importorskip("rosbags")
pytest.importorskip("mcap")
pytest.importorskip("pyarrow")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("fuzz")
    targets.write_seeds(path / "seeds")
    return path


@pytest.mark.parametrize("target", [t for t in targets.TARGETS if t != "arguments"])
@pytest.mark.filterwarnings("ignore")  # of libraries that read what is damaged
def test_a_mutated_input_is_read_or_refused_in_one_line(target, folder):
    @settings(
        max_examples=6, deadline=None, derandomize=True, database=None,
        suppress_health_check=list(HealthCheck),
    )  # fmt: skip
    @given(seed=st.integers(0, 2**32 - 1))
    def check(seed):
        assert targets.attempt(target, folder / "seeds", seed, folder / "scratch") in (
            "ok", "refused",
        )  # fmt: skip

    check()


@pytest.mark.parametrize("target", targets.FILES)
def test_every_seed_is_read_as_it_is(target, folder):
    path = folder / "seeds" / (target if not target.startswith("bag/") else "bag")
    assert targets.read_tables(path)


def test_a_mat_file_that_crashes_its_reader_is_refused_in_one_line(folder):
    path = folder / "crash.mat"
    # Input 9904 of the campaign: scipy 1.17 follows a damaged length out of its memory.
    path.write_bytes(mutated((folder / "seeds" / "log.mat").read_bytes(), 9904))
    reason = r"crash\.mat: (it crashed its reader \(SIG\w+\)|unreadable .*); expected a MATLAB file"
    with pytest.raises(InputError, match=reason) as caught:
        targets.command_line(["import", str(path), "--kind", "slider", "--yes", "--out", "out"])
    assert "\n" not in str(caught.value)


@settings(max_examples=25, deadline=None, derandomize=True, database=None)
@given(
    st.lists(
        st.sampled_from([*targets.RISKY, "import", "data", "diagnose", "--out", "--yes"]),
        max_size=6,
    )
)
def test_any_command_line_is_answered(words):
    with contextlib.suppress(InputError):
        targets.command_line(words)


def test_a_description_that_stands_for_billions_of_values_is_refused(folder):
    from gapscope.analysis.gap.logset import load_logset

    bomb = folder / "bomb"
    bomb.mkdir()
    (bomb / "logset.yaml").write_bytes(b"format: 1\n" + BOMB + b"\nsystem: {kind: *b10}\n")
    with pytest.raises(InputError, match="at most 100000"):
        load_logset(bomb)


def test_mutations_are_repeatable_and_change_something():
    data = bytes(range(256)) * 4
    assert mutated(data, 7) == mutated(data, 7)
    assert sum(mutated(data, seed) != data for seed in range(100)) > 90


@pytest.mark.slow
def test_ten_thousand_mutated_inputs(tmp_path):
    count = int(os.environ.get("GAPSCOPE_FUZZ", "10000"))
    found = campaign.run(count, tmp_path)
    assert sum(found["outcomes"].values()) == count
    assert found["failures"] == []


@pytest.mark.slow
@pytest.mark.parametrize("target", ["log.csv", "log.mcap", "logset.yaml"])
def test_inputs_that_reach_new_code_are_read_or_refused_too(target, tmp_path):
    pytest.importorskip("atheris", reason="atheris is not installed: pip install --group fuzz")
    done = subprocess.run(
        [sys.executable, "-m", "fuzz.guided", target, str(tmp_path), "20"],
        cwd=Path(__file__).parents[1], capture_output=True, text=True,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-2000:]
    assert int(re.search(r"number_of_executed_units: (\d+)", done.stderr)[1]) > 100
