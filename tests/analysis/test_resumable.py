"""A map that was stopped goes on where it was."""

import pytest

from gapscope.analysis.resumable import resumable_map

calls = []


def square(x):
    calls.append(x)
    if x == 3 and calls.count(3) == 1:
        raise RuntimeError("stopped")
    return {"square": x * x}


def test_finished_cases_survive_a_failure_and_are_not_repeated(tmp_path):
    calls.clear()
    cases = [{"x": x} for x in (1, 2, 3, 4)]
    with pytest.raises(RuntimeError):
        resumable_map(square, cases, tmp_path)
    seen = []
    results = resumable_map(
        square, cases, tmp_path, progress=lambda done, total: seen.append((done, total))
    )
    assert results == [{"square": x * x} for x in (1, 2, 3, 4)]
    assert calls == [1, 2, 3, 3, 4]
    assert seen == [(2, 4), (3, 4), (4, 4)]


def test_no_workers_is_refused(tmp_path):
    with pytest.raises(ValueError, match="expected at least 1"):
        resumable_map(square, [], tmp_path, workers=0)
