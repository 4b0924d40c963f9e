"""Several diagnoses on one page: in words, escaped, and quiet in a browser."""

import json
import shutil
import subprocess

import numpy as np
import pytest
from matplotlib import image

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.report.compare import FILE, headline, load, page, write_comparison

from .test_report import Outline
from .test_report_in_browser import NAMES, run

HOSTILE = "<img src=x onerror=alert(1)>"


def diagnosis(verdict, effects, **shrinkage):
    return {
        "verdict": verdict,
        "effects": [
            {
                "id": effect,
                "where": {"elements": ["left"]},
                "probability": 0.97,
                "parameters": {"level_left": {"value": 0.31, "unit": "N m"}},
            }
            for effect in effects
        ],
        "location": {
            "joints": [{"name": "left", "share": 0.8}, {"name": "right", "share": 0.2}],
            "regimes": [{"name": "slow", "share": 0.6}, {"name": HOSTILE, "share": 0.4}],
            "bands": [],
        },
        "shrinkage": {"metric": "rms unexplained N m", "before": 0.3, "retuned": 0.2, "after": 0.02,
                      "floor": 0.01, "percent": 96.6, "ci95": [95.0, 98.0], **shrinkage},
        "warnings": [HOSTILE],
        "provenance": {"logset": HOSTILE, "seed": 0, "seconds": 120.00617815499572},
    }  # fmt: skip


@pytest.fixture
def folders(tmp_path):
    contents = {
        "monday": diagnosis("explained", ["friction.coulomb"]),
        "tuesday": diagnosis("explained", ["friction.coulomb", "load.bias"]),
        "wednesday": diagnosis("no_gap", [], percent=None, ci95=None, after=None),
    }
    for name, content in contents.items():
        (tmp_path / name).mkdir()
        (tmp_path / name / "diagnosis.json").write_text(json.dumps(content))
    return [tmp_path / name for name in contents]


def test_it_says_first_what_they_share_and_where_they_part(folders):
    assert headline(load(folders)) == (
        "Of 3 diagnoses: 2 explained and 1 no gap. Only in some: friction.coulomb and load.bias."
    )
    assert "Named in every one: friction.coulomb." in headline(load(folders[:2]))


def test_confidence_is_that_of_the_weakest_effect(folders):
    content = json.loads((folders[1] / "diagnosis.json").read_text())
    content["effects"][1]["probability"] = 0.75
    (folders[1] / "diagnosis.json").write_text(json.dumps(content))
    text = page(load(folders[:2]))
    assert text.count("<td>high</td>") == text.count("<td>moderate</td>") == 1


def test_page_is_well_formed_and_holds_every_number(folders):
    outline = Outline(page(load(folders)))
    words = outline.words
    for text in (
        "monday",
        "tuesday",
        "wednesday",
        "97",
        "at left",
        "level_left 0.31",
        "95",
        "80 %",
    ):
        assert text in words
    assert not outline.all("img")
    assert not outline.all("script")
    headings = [tag for tag, _ in outline.elements if tag in ("h1", "h2")]
    assert headings[0] == "h1"
    assert headings.count("h1") == 1


def test_shares_without_a_gap_and_seconds_are_said_as_they_are(folders):
    said = Outline(page(load(folders))).words
    assert "Without a gap (wednesday) they are shares of what is left at the noise floor." in said
    assert "seconds 120.0 " in said
    assert "Without a gap" not in Outline(page(load(folders[:2]))).words


def test_folders_of_one_name_are_told_apart(folders, tmp_path):
    twin = tmp_path / "other" / "monday"
    shutil.copytree(folders[0], twin)
    names = [d.name for d in load([folders[0], twin])]
    assert len(set(names)) == 2
    assert names[1] == "other/monday"


def test_bad_input_is_one_message(folders, tmp_path):
    for paths, message in (
        (folders[:1], "two or more"),
        ([folders[0], folders[0]], "given twice"),
        ([folders[0], tmp_path / "nowhere"], "gapscope diagnose"),
    ):
        with pytest.raises(InputError, match=message):
            load(paths)
    for text, message in (
        ("{", "not JSON"),
        ("[]", "no key 'verdict'"),
        ("{}", "no key 'verdict'"),
    ):
        (folders[1] / "diagnosis.json").write_text(text)
        with pytest.raises(InputError, match=message):
            load(folders)


@pytest.mark.parametrize("dark", [False, True])
def test_it_is_drawn_light_and_dark_in_a_browser(folders, tmp_path, dark):
    browser = next((path for path in map(shutil.which, NAMES) if path), None)
    if browser is None:
        pytest.skip(f"no Chromium on this machine (looked for {', '.join(NAMES)})")
    picture = tmp_path / "page.png"
    html = write_comparison(load(folders), tmp_path / "out").read_text()
    assert (tmp_path / "out" / FILE).exists()
    try:
        _, console = run(
            browser, tmp_path, html, f"--screenshot={picture}", "--window-size=1000,1900",
            f"--blink-settings=preferredColorScheme={0 if dark else 1}",
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        pytest.skip("the browser did not answer within a minute")
    assert console == []
    grey = image.imread(picture)[..., :3].mean(axis=2)
    assert (np.median(grey) < 0.2) == dark
