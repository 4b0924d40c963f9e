"""``gapscope compare c-drive``: its rows, its files, and its page standing alone."""

import json
import re
import xml.etree.ElementTree as ET

import pytest
from typer.testing import CliRunner

from gapscope.analysis import cli
from gapscope.analysis.comparison import compare_c_drive
from gapscope.models import thesis_tables


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("results") / "below" / "comparison"
    result = CliRunner().invoke(cli.app, ["compare", "c-drive", "--out", str(out)])
    assert result.exit_code == 0, result.output
    return out


@pytest.fixture(scope="module")
def rows(folder):
    return json.loads((folder / "comparison.json").read_text())["rows"]


def test_exactly_the_three_files_are_left(folder):
    assert sorted(path.name for path in folder.iterdir()) == [
        "comparison.html",
        "comparison.json",
        "comparison.md",
    ]


def test_every_printed_number_has_one_row(rows):
    keys = {(r["controller"], r["motion"], r["metric"], r["rate_Hz"]) for r in rows}
    assert keys == {(*row.key, row.rate_Hz) for row in thesis_tables.all_rows()}
    assert len(rows) == len(keys)


def test_relative_error_is_against_the_printed_simulation_and_null_where_there_is_none(rows):
    for row in rows:
        if row["thesis_sim"]:
            assert row["relative_error"] == pytest.approx(row["ours"] / row["thesis_sim"] - 1.0)
        else:
            assert row["relative_error"] is None
    assert any(row["thesis_sim"] == 0.0 for row in rows)
    assert all(row["thesis_sim"] is None for row in rows if row["rate_Hz"] == 1.0)


def test_ct_errors_are_reproduced_within_two_percent(rows):
    by_key = {(r["controller"], r["motion"], r["metric"]): r for r in rows if r["rate_Hz"] == 2.0}
    for motion in ("translation", "helical"):
        assert abs(by_key["ct", motion, "e_u_rms_mm"]["relative_error"]) < 0.02


def test_provenance_names_program_source_and_settings(folder):
    provenance = json.loads((folder / "comparison.json").read_text())["provenance"]
    assert provenance["program"].startswith("gapscope ")
    assert provenance["ours"]["dead_zone_counts"] == 1.0
    assert provenance["controllers"]["ct"]["poles"] == [[-600.0, 0.0], [-600.0, 0.0]]


def test_markdown_tables_have_as_many_rows_as_the_document(folder, rows):
    lines = (folder / "comparison.md").read_text().splitlines()
    tables = [line for line in lines if line.startswith("| ") and not line.startswith("| motion |")]
    assert len(tables) == len(rows)


def test_page_loads_nothing_and_its_figures_are_valid_and_share_no_ids(folder):
    page = (folder / "comparison.html").read_text()
    assert not re.search(r'(src|href)="(?!#|http://www\.w3\.org)[^"]', page)
    assert "prefers-color-scheme: dark" in page
    figures = re.findall(r"<svg .*?</svg>", page, flags=re.DOTALL)
    assert len(figures) == 4
    ids = [
        element.get("id")
        for figure in figures
        for element in ET.fromstring(figure).iter()
        if element.get("id")
    ]
    assert len(ids) == len(set(ids))
    used = set(re.findall(r'href="#([^"]+)"|url\(#([^)]+)\)', page))
    assert {a or b for a, b in used} <= set(ids)


def test_same_input_gives_the_same_document(rows):
    again = json.loads(json.dumps(compare_c_drive().as_json()))["rows"]
    assert again == rows
