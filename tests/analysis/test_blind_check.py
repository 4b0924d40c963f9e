"""Seal, resume and failure of a blind run, with made-up diagnoses."""

import json

import pytest

from gapscope.analysis import blind_check, blind_machine
from gapscope.analysis.errors import InputError


@pytest.fixture
def quick_cases(monkeypatch):
    """Cases without simulation: an answer and a one-line log."""

    def write_case(seed, index, directory):
        directory.mkdir(parents=True)
        (directory / "logset.yaml").write_text(f"seed: {seed}\nindex: {index}\n")
        return {"name": blind_machine.case_name(index), "answer": ["load.bias"], "index": index}

    monkeypatch.setattr(blind_check, "write_case", write_case)


def no_gap(logset, out):
    return {"verdict": "no_gap", "seen": sorted(p.name for p in logset.iterdir())}


def run(out, diagnose=no_gap, **changes):
    return blind_check.run(**{"seed": 7, "cases": 5, "out": out, "diagnose": diagnose, **changes})


def test_the_seal_is_there_before_the_first_diagnosis(tmp_path, quick_cases):
    announced = []

    def diagnose(logset, out):
        assert announced
        assert (tmp_path / "sealed.json").exists()
        return no_gap(logset, out)

    opened = run(tmp_path, diagnose, sealed=announced.append)
    assert [answer["index"] for answer, _ in opened] == [0, 1, 2, 3, 4]
    assert all(result["error"] is None for _, result in opened)
    assert opened[0][1]["diagnosis"]["seen"] == ["logset.yaml"]
    sealed = json.loads((tmp_path / "sealed.json").read_text())
    assert len(set(sealed["answers"].values())) == 5  # salted: equal answers, different hashes
    assert "load.bias" not in json.dumps(sealed)
    assert sealed["use"] == "tuning"


@pytest.mark.parametrize("change", ["answer", "salt", "log"])
def test_a_changed_answer_salt_or_log_breaks_the_seal(tmp_path, quick_cases, change):
    run(tmp_path)
    assert blind_check.verify(tmp_path) == []
    path = tmp_path / "answers" / "case_0002.json"
    content = json.loads(path.read_text())
    if change == "log":
        (tmp_path / "cases" / "case_0002" / "logset.yaml").write_text("easier\n")
    elif change == "salt":
        content["salt"] = content["salt"][::-1]
    else:
        content["answer"]["answer"] = ["actuator.delay"]
    path.write_text(json.dumps(content))
    assert blind_check.verify(tmp_path) == ["case_0002"]
    with pytest.raises(InputError, match="case_0002"):
        run(tmp_path)


def test_a_killed_run_resumes_where_it_stopped(tmp_path, quick_cases):
    seen = []

    def killed(logset, out):
        if len(seen) == 3:
            raise KeyboardInterrupt
        seen.append(logset.name)
        return no_gap(logset, out)

    with pytest.raises(KeyboardInterrupt):
        run(tmp_path, killed)
    before = (tmp_path / "sealed.json").read_bytes()
    assert len(seen) == 3
    again = []

    def counted(logset, out):
        again.append(logset.name)
        return no_gap(logset, out)

    run(tmp_path, counted)
    assert sorted(seen + again) == [blind_machine.case_name(i) for i in range(5)]
    assert (tmp_path / "sealed.json").read_bytes() == before


def test_a_crash_is_a_failed_case_and_is_tried_again(tmp_path, quick_cases):
    def crashing(logset, out):
        if logset.name == "case_0001":
            raise ZeroDivisionError("no floor")
        return no_gap(logset, out)

    opened = run(tmp_path, crashing)
    assert [result["error"] for _, result in opened].count("ZeroDivisionError: no floor") == 1
    assert all(result["error"] is None for _, result in run(tmp_path))


def test_a_folder_of_another_run_is_refused(tmp_path, quick_cases):
    run(tmp_path)
    with pytest.raises(InputError, match="5 cases of drive, seed 7"):
        run(tmp_path, seed=8)
    with pytest.raises(InputError, match="5 cases of drive, seed 7"):
        run(tmp_path, cases=6)


def test_two_processes_give_the_results_of_one(tmp_path):
    """Real cases, real processes: nothing depends on who wrote them."""
    said = lambda logset, out: {"verdict": "no_gap"}  # noqa: E731  (pickled by value)
    one = run(tmp_path / "one", said, cases=2)
    two = run(tmp_path / "two", said, cases=2, workers=2)
    assert [answer for answer, _ in one] == [answer for answer, _ in two]


def test_seeds_are_labelled():
    assert blind_check.label(999) == "tuning"
    assert blind_check.label(1000) == "report"
