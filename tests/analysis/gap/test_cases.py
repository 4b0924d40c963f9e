"""The page of cases is written from diagnoses, and the page in the repository has its structure."""

import re
from pathlib import Path

import pytest
import yaml

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.cases import log_sets, write_cases

from .test_piezo_stack import write

PAGE = Path(__file__).resolve().parents[3] / "analysis" / "gap" / "CASES.md"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A page of one set that lags and one whose kind nobody knows, with the calls of progress."""
    folder = tmp_path_factory.mktemp("sets")
    write(folder / "lagging", lag=0.02)
    document = yaml.safe_load((write(folder / "unknown") / "logset.yaml").read_text())
    document["system"] = {"kind": "trampoline"}
    (folder / "unknown" / "logset.yaml").write_text(yaml.safe_dump(document))
    calls = []
    for _ in range(2):  # the second takes the diagnoses of the first up
        out = write_cases(
            [("Some", log_sets(folder))], folder / "CASES.md", folder / "work",
            progress=lambda done, total: calls.append((done, total)),
        )  # fmt: skip
    return out.read_text(), calls, folder


def test_a_set_is_summarised_with_effect_shrinkage_and_cost(page):
    text, _, _ = page
    row = next(line for line in text.splitlines() if line.startswith("| lagging |"))
    assert re.fullmatch(
        r"\| lagging \| piezo_stack \| explained \| actuator\.lag \| [\d.]+ % \[[\d.]+, [\d.]+\] "
        r"\| [\d.]+ s \| \d+ \|",
        row,
    )
    found = re.search(r"time_constant = ([\d.]+) \[[\d.]+, [\d.]+\] s", text)
    assert float(found[1]) == pytest.approx(0.02, rel=0.03)


def test_a_set_that_cannot_be_read_is_listed_with_its_error_and_no_path(page):
    text, _, folder = page
    assert "| unknown | | not diagnosed | | | | |" in text
    assert (
        "Not diagnosed: unknown/logset.yaml: system.kind is 'trampoline'; expected one of" in text
    )
    assert str(folder) not in text


def test_finished_diagnoses_are_taken_up(page):
    _, calls, _ = page
    assert calls == [(0, 2), (1, 2), (2, 2), (2, 2)]


def structure(text):
    """Headings of the second level apart, the lines every page has; then the beginnings of case lines."""
    lines = text.splitlines()
    head = lines[: lines.index("|---|---|---|---|---|---|---|") + 1]
    return head, {m[1] for line in lines if (m := re.match(r"- ([A-Z][a-z]+)[:,]", line))}


def test_the_page_in_the_repository_has_this_structure(page):
    mine, its = structure(page[0]), structure(PAGE.read_text())
    assert mine[0] == its[0]
    assert mine[1] - {"Note"} <= its[1]


def test_a_folder_without_log_sets_is_refused(tmp_path):
    with pytest.raises(InputError, match="no log sets"):
        log_sets(tmp_path)
