"""``report.html``: whole, readable, safe, and true to the diagnosis."""

import base64
import json
import os
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from gapscope.analysis import cli
from gapscope.analysis.gap import report
from gapscope.analysis.gap.report import base, series, waterfall, which, words
from gapscope.analysis.gap.signals import SignalFinding
from gapscope.analysis.gap.verdict import Verdict, with_findings

from .conftest import HOSTILE, LEVEL

BREAKS = {"td", "th", "li", "dt", "dd", "p", "caption", "figcaption"}
VOID = {"meta", "link", "br", "rect", "path"}


class Outline(HTMLParser):
    """Open tags, attributes and text of a page; fails on tags that do not nest."""

    def __init__(self, html):
        super().__init__()
        self.open, self.elements, self.text = [], [], []
        self.feed(html)
        self.close()
        assert not self.open

    def handle_starttag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag
        if tag in BREAKS:
            self.text.append(" ")

    def handle_startendtag(self, tag, attributes):
        self.elements.append((tag, dict(attributes)))

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.text.append(data)

    @property
    def words(self):
        return " ".join("".join(self.text).replace("\N{NO-BREAK SPACE}", " ").split())

    def all(self, tag):
        return [attributes for name, attributes in self.elements if name == tag]


def outline(diagnosis):
    return Outline(report.page(diagnosis))


@pytest.fixture(scope="module")
def page(diagnosed):
    return report.page(diagnosed["friction"])


def with_verdict(diagnosis, kind):
    """The same diagnosis as if its verdict were another one."""
    first, second = diagnosis.ranking[:2]
    verdict = Verdict(
        verdict=kind,
        reason="made up for this test",
        accepted=first if kind == "ambiguous" else None,
        rivals=(second,) if kind == "ambiguous" else (),
        removed=0.4,
    )
    chosen = first.fit if kind == "ambiguous" else diagnosis.retuned
    return replace(diagnosis, verdict=verdict, chosen=chosen)


def test_one_file_is_written_with_every_section_under_its_heading(diagnosed, tmp_path):
    path = report.write_report(diagnosed["friction"], tmp_path / "new" / "folder")
    assert [p.name for p in path.parent.iterdir()] == ["report.html"]
    found = Outline(path.read_text(encoding="utf-8"))
    labelled = [s["aria-labelledby"] for s in found.all("section")]
    ids = [a["id"] for _, a in found.elements if "id" in a]
    assert len(labelled) == len(report.SECTIONS) == 9
    assert set(labelled) <= set(ids)
    assert len(ids) == len(set(ids))
    assert {a["href"] for a in found.all("a")} <= {f"#{i}" for i in ids}


def test_page_needs_nothing_from_outside_and_stays_small(page):
    assert not re.search(r"https?:|src\s*=|@import|url\(", page.replace("&lt;img src=x", ""))
    assert "default-src 'none'" in page
    assert len(page.encode()) < 1_500_000


def test_names_from_the_log_set_stay_text(page):
    found = Outline(page)
    assert not found.all("img")
    assert not found.all("b")
    assert len(found.all("script")) == 2
    assert HOSTILE in found.words
    assert "friction </script> & <b>" in found.words


def test_words_and_labels_for_those_who_do_not_see_the_pictures(page):
    found = Outline(page)
    for picture in found.all("svg"):
        assert picture.get("aria-hidden") == "true" or picture.get("aria-label")
    for region in (a for a in found.all("div") if a.get("class") == "table"):
        assert region["tabindex"] == "0"
        assert region["aria-label"]
    assert found.all("html")[0]["lang"] == "en"


def test_verdict_comes_first_and_says_effect_place_confidence_and_how_far(diagnosed, page):
    said = Outline(page).words
    d = diagnosed["friction"]
    assert d.verdict.verdict == "explained"
    assert "The gap comes from friction.coulomb at left." in said
    assert "Confidence: very high." in said
    assert f"That removes {d.shrinkage.percent:.1f} % of the gap" in said
    level = re.search(r"level_left ([\d.]+) N m ([\d.]+) to ([\d.]+) N m", said)
    value, low, high = map(float, level.groups())
    assert low < value < high
    assert value == pytest.approx(LEVEL, rel=0.01)
    assert "at the end of its range" not in said


def test_where_names_no_winner_among_equals(diagnosed):
    d = diagnosed["friction"]
    equal = [{"name": name, "share": share} for name, share in (("left", 0.504), ("right", 0.496))]
    said = outline(replace(d, location={"joints": equal})).words
    assert "Where it lies: evenly on left and right." in said
    apart = [{"name": name, "share": share} for name, share in (("left", 0.6), ("right", 0.4))]
    assert "Where it lies: 60 % on left." in outline(replace(d, location={"joints": apart})).words


def test_tolerance_has_its_unit_and_a_wide_interval_its_note(diagnosed, page):
    said = Outline(page).words
    assert re.search(r"tolerance retuned alone .*? kg m² [\d.]+ to [\d.]+ kg m²", said)
    p = next(p for p in diagnosed["friction"].machine.own)
    middle = 0.5 * (p.lower + p.upper)
    assert which._note(middle, p.upper - p.lower, p) == "interval passes the end of its range"
    assert which._note(middle, 0.0, p) == ""


def test_command_in_the_next_experiment_is_marked_up(page):
    assert "<code>gapscope design LOGSET</code>" in page
    assert "`" not in Outline(page).words


def test_how_far_has_an_interval_beside_each_measured_level(diagnosed, page):
    s = diagnosed["friction"].shrinkage
    assert s.after < s.retuned <= s.before
    for level in ("before", "retuned", "after"):
        low, high = s.intervals[level]
        assert low < getattr(s, level) < high
        assert f"{words.interval((low, high), 'N m')}" in page
    assert (s.intervals["floor"] is None) == ("resolution" in s.floor_source)
    for name, ends in diagnosed["friction"].to_json()["shrinkage"]["intervals_ci95"].items():
        assert ends == (None if s.intervals[name] is None else list(s.intervals[name]))


def test_how_the_log_was_read_is_said_in_front(diagnosed):
    d = diagnosed["friction"]
    notes = ("10 stretches stand for it", "the clock jitters", "so does this one")
    said = outline(replace(d, logset=replace(d.logset, notes=notes))).words
    front = said[: said.index("What makes up the gap Rms")]
    assert "How the log was read: 10 stretches stand for it" in front
    assert "How the log was read: the clock jitters" in front
    assert "so does this one" not in front
    assert "1 more such notes" in front


def test_every_hypothesis_is_ranked_with_a_reason(diagnosed, page):
    said = Outline(page).words
    for ranked in diagnosed["friction"].ranking:
        assert ranked.fit.hypothesis.label in said
    assert "The runner-up, " in said
    assert "lost because" in said


def test_growing_inverse_models_are_shown(diagnosed, page):
    said = Outline(page).words
    for structure in diagnosed["friction"].inverse_model:
        size = words.percent(structure.relative_error, 1).replace("\N{NO-BREAK SPACE}", " ")
        assert f"{structure.name} {size}" in " ".join(said.split())


def test_no_gap_is_said_without_an_effect(diagnosed):
    assert diagnosed["nothing"].verdict.verdict == "no_gap"
    said = outline(diagnosed["nothing"]).words
    assert "there is no gap to explain" in said
    assert "Effects found" not in said
    assert "Accepted: retuned nominal" in said


def test_fault_of_the_log_is_said_to_lie_in_the_log(diagnosed):
    finding = SignalFinding(
        effect="sensor.timing",
        form="positions late",
        where={"joints": ["left", "right"]},
        parameters={"late": {"value": 0.002, "unit": "s"}},
        evidence="the replay says so",
        before=0.2,
        after=0.01,
    )
    d = diagnosed["nothing"]
    verdict = with_findings(d.verdict, [finding])
    said = outline(replace(d, findings=(finding,), verdict=verdict)).words
    assert "The gap lies in the log, not in the machine: sensor.timing (positions late)." in said
    assert "both left and right" in said
    assert "late 0.00200 s" in said
    assert "sensor.timing corrected in the log" in said


def test_two_effects_are_two_steps_of_the_waterfall(diagnosed):
    d = diagnosed["two"]
    assert sorted(d.verdict.accepted.fit.hypothesis.ids) == ["friction.coulomb", "load.bias"]
    labels = [row["label"] for row in waterfall.context(base.Material(d))["rows"]]
    assert labels[2:4] == ["+ friction.coulomb", "+ load.bias"]
    said = outline(d).words
    assert "friction.coulomb at left" in said
    assert "load.bias at right" in said
    assert sum(share.share for share in d.shares) == pytest.approx(1.0)


def test_what_rivals_share_is_said_to_be_sure(diagnosed):
    d = diagnosed["two"]
    mine = d.verdict.accepted.fit.hypothesis.ids
    with_another = next(
        r
        for r in d.ranking
        if len(r.fit.hypothesis.ids) == 2
        and len({"friction.coulomb", *mine} & set(r.fit.hypothesis.ids)) == 1
    )
    (other,) = set(with_another.fit.hypothesis.ids) - set(mine)
    verdict = replace(d.verdict, verdict="ambiguous", rivals=(with_another,))
    said = outline(replace(d, verdict=verdict)).words
    assert "comes from friction.coulomb at left, together with load.bias at " in said
    assert f" or {other}" in said
    assert "Confidence in friction.coulomb: very high" in said
    assert "not separated: " in said


@pytest.mark.parametrize(
    ("kind", "phrases"),
    [
        ("unexplained", ("no effect of the catalogue explains", "40 %", "not believed")),
        ("ambiguous", ("these data cannot tell which", "Confidence in one of them: low", " or ")),
    ],
)
def test_other_verdicts_are_said_plainly(diagnosed, kind, phrases):
    said = outline(with_verdict(diagnosed["friction"], kind)).words
    for phrase in phrases:
        assert phrase in said


def test_waterfall_ends_where_shrinkage_does_and_never_jumps(diagnosed):
    d = diagnosed["friction"]
    rows = waterfall.context(base.Material(d))["rows"]
    assert rows[0]["value"] == words.number(d.shrinkage.before, "N m")
    assert rows[-2]["value"] == words.number(d.shrinkage.after, "N m")
    ends = [row["x"] for row in rows if row["kind"] == "fall"]
    tops = [row["x"] + row["width"] for row in rows if row["kind"] == "fall"]
    np.testing.assert_allclose(tops, [rows[0]["width"], *ends[:-1]], atol=1e-9)
    assert ends[-1] == pytest.approx(rows[-2]["width"])


def test_runner_up_with_smaller_error_lost_to_the_price_of_its_freedom(diagnosed):
    ranking = diagnosed["friction"].ranking
    winner = ranking[0]
    for rival in ranking[1:]:
        reason = which.why_not(rival, winner)
        ratio = rival.fit.held_out_rms / winner.fit.held_out_rms
        assert ("smaller" in reason) == (ratio <= 1.02)


def test_heat_map_and_lists_share_out_the_same_gap(diagnosed):
    location = diagnosed["friction"].location
    for table, across, key in (
        ("joint_regimes", "regime", "regimes"),
        ("joint_bands", "band", "bands"),
    ):
        for entry in location[key]:
            cells = [c["share"] for c in location[table] if c[across] == entry["name"]]
            assert sum(cells) == pytest.approx(entry["share"], abs=1e-12)
    for joint in location["joints"]:
        cells = [c["share"] for c in location["joint_regimes"] if c["joint"] == joint["name"]]
        assert sum(cells) == pytest.approx(joint["share"], abs=1e-12)


def test_series_carry_the_signals_to_a_thousandth_of_their_range(diagnosed, page):
    run = next(r for r in diagnosed["friction"].runs if r.use == "validate")
    data = json.loads(re.search(r'id="series-data">(.*?)</script>', page, re.S)[1])
    panel = next(p for p in data["panels"] if p["title"] == "Command, left")
    assert [s["name"] for s in panel["series"]] == ["measured", "nominal", "diagnosed"]
    s = panel["series"][0]
    values = s["offset"] + s["scale"] * np.frombuffer(base64.b64decode(s["data"]), "<i2")
    np.testing.assert_allclose(values, run.command[:, 0], atol=1e-3 * np.ptp(run.command[:, 0]))


def test_decimation_keeps_every_extreme():
    values = np.random.default_rng(0).normal(size=100_003)
    fewer = series.decimated(values, 1000)
    assert len(fewer) == 1000
    for kept, bucket in zip(np.array_split(fewer, 500), np.array_split(values, 500)):
        assert kept.min() <= bucket[50:150].min()
        assert kept.max() >= bucket[50:150].max()
    assert series.decimated(values, 200_000) is values


def test_constant_and_zero_series_are_packed():
    for value in (0.0, 3.5):
        pack = series.packed(np.full(10, value))
        integers = np.frombuffer(base64.b64decode(pack["data"]), "<i2")
        np.testing.assert_array_equal(pack["offset"] + pack["scale"] * integers, value)


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (0.181, "0.181"), (1.55e-5, "1.55 × 10⁻⁵"), (-2.0, "−2.00"), (123456.0, "1.23 × 10⁵"),
        (0.0, "0.00"), (float("nan"), "–"), (None, "–"),
    ],
)  # fmt: skip
def test_numbers_are_written_for_people(value, text):
    assert words.number(value) == text


def test_intervals_have_as_many_digits_as_tell_their_ends_apart():
    assert words.interval((0.299837, 0.299990)) == "0.29984 to 0.29999"
    assert words.interval((-1.0, 2.0)) == "−1.00 to 2.00"
    assert words.interval((0.0, 0.0)) == "0.00 to 0.00"


def test_shares_never_round_to_nothing_or_all():
    assert words.percent(1e-5) == "<1\N{NO-BREAK SPACE}%"
    assert words.percent(0.99999, 1) == ">99.9\N{NO-BREAK SPACE}%"
    assert words.percent(1.0) == "100\N{NO-BREAK SPACE}%"


def test_command_writes_the_report_beside_the_diagnosis(diagnosed, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "gapscope.analysis.gap.diagnosis.diagnose", lambda *args, **options: diagnosed["friction"]
    )
    result = CliRunner().invoke(cli.app, ["diagnose", "anything", "--out", str(tmp_path)])
    assert result.exit_code == 0, result.output
    assert sorted(p.name for p in tmp_path.iterdir()) == ["diagnosis.json", "report.html"]
    assert str(tmp_path / "report.html") in result.output


@pytest.mark.slow
def test_open_sets_have_a_report_of_their_verdict(tmp_path):
    data = os.environ.get("GAPSCOPE_DATA")
    folder = Path(data).parent / "gap" / "open" if data else None
    if folder is None or not folder.is_dir():
        pytest.skip("GAPSCOPE_DATA is not set, or ../gap/open is not beside it")
    from gapscope.analysis.gap.diagnosis import diagnose

    for name, phrase in (
        ("coulomb_left", "The gap comes from friction.coulomb at left."),
        ("none", "there is no gap to explain"),
    ):
        path = report.write_report(diagnose(folder / name), tmp_path / name)
        assert phrase in Outline(path.read_text(encoding="utf-8")).words
