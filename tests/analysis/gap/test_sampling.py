"""Resampling and stretches: the physics survives, and what was done is said."""

import numpy as np
import pytest
import yaml

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap import sampling, stretches
from gapscope.analysis.gap.logset import load_logset, logset_from_frames

from .conftest import description

DT = 1e-3


def table(t, frequency=2.0):
    q = np.sin(2.0 * np.pi * frequency * t)
    return {"t": t, "q": q, "force": np.cos(2.0 * np.pi * frequency * t)}


def jittery(samples=2000, seed=0):
    rng = np.random.default_rng(seed)
    return DT * (np.arange(samples) + rng.uniform(-0.3, 0.3, samples))


def pieces(columns, **options):
    return sampling.read_pieces(sampling.Path("run"), list(columns), DT, table=columns, **options)


def test_a_jittery_clock_is_refused_until_resampling_is_asked_for():
    with pytest.raises(InputError, match="resample: linear"):
        pieces(table(jittery()))


def test_resampling_keeps_the_signal_and_says_what_it_did():
    (piece,) = pieces(table(jittery()), resample=True)
    np.testing.assert_allclose(np.diff(piece.columns["t"]), DT, rtol=1e-9)
    # Linear interpolation is wrong by at most h^2/8 times the second derivative, h <= 1.6 ms.
    bound = (1.6 * DT) ** 2 / 8.0 * (4.0 * np.pi) ** 2
    exact = np.sin(4.0 * np.pi * piece.columns["t"])
    assert np.max(np.abs(piece.columns["q"] - exact)) < bound
    (note,) = piece.notes
    assert "resampled" in note
    assert "rms jitter" in note


def test_an_even_clock_is_not_resampled_and_has_no_notes():
    even = table(DT * np.arange(1000))
    (piece,) = pieces(even, resample=True)
    assert piece.notes == ()
    np.testing.assert_array_equal(piece.columns["q"], even["q"])


def test_small_jitter_is_reported():
    t = DT * (np.arange(1000) + 0.02 * (np.arange(1000) % 2))
    (piece,) = pieces(table(t))
    assert "taken as uniform" in piece.notes[0]


def test_no_data_are_invented_across_a_gap():
    t = jittery()
    t[1000:] += 0.5
    with pytest.raises(InputError, match=r"row 1002.*without a sample"):
        pieces(table(t), resample=True)


@pytest.fixture
def short_windows(monkeypatch):
    monkeypatch.setattr(stretches, "LONGEST", 5_000)
    monkeypatch.setattr(stretches, "LENGTH", 200)
    monkeypatch.setattr(stretches, "COUNT", 5)


def long_table():
    """Gentle motion for 40 s, but for one window that is fast and one with a dead sensor."""
    columns = table(DT * np.arange(40_000), frequency=0.5)
    columns["q"][12_000:12_200] *= np.cos(2.0 * np.pi * 60.0 * columns["t"][12_000:12_200])
    columns["force"][30_010] = np.nan
    columns["t"][35_100:] += 0.25
    return columns


def test_a_long_table_is_read_as_stretches_that_hold_its_rare_regimes(short_windows):
    found = pieces(long_table())
    assert len(found) == 5
    begins = [round(piece.begins / DT) for piece in found]
    assert begins[0] == 0
    assert begins[-1] == round((39_800 * DT + 0.25) / DT)
    assert 12_000 in begins
    for piece in found:
        assert piece.columns["t"].size == 200
        assert all(np.isfinite(values).all() for values in piece.columns.values())
    (note,) = [note for piece in found for note in piece.notes]
    assert "40000 rows" in note
    assert "2 of 200 windows were passed over" in note


def test_stretches_do_not_depend_on_how_the_table_is_cut_into_blocks(short_windows):
    columns = long_table()
    whole = np.column_stack(list(columns.values()))
    rng = np.random.default_rng(1)
    cuts = np.sort(rng.choice(np.arange(1, len(whole)), 60, replace=False))
    surveys = [stretches.survey(parts, 0, DT, 0.1) for parts in ([whole], np.split(whole, cuts))]
    chosen = [stretches.choose(survey) for survey in surveys]
    assert chosen[0] == chosen[1]
    for a, b in zip(
        stretches.collect([whole], chosen[0]), stretches.collect(np.split(whole, cuts), chosen[0])
    ):
        np.testing.assert_array_equal(a, b)


def test_a_long_table_without_a_usable_window_is_one_error(short_windows):
    columns = long_table()
    columns["force"][:] = np.nan
    with pytest.raises(InputError, match="no 200 rows without a gap"):
        pieces(columns)


def test_frames_in_memory_are_the_log_set_on_disk(nominal_logset):
    pandas = pytest.importorskip("pandas")
    frames = {f"run{i}.csv": pandas.read_csv(nominal_logset / f"run{i}.csv") for i in range(4)}
    memory, disk = logset_from_frames(description(), frames), load_logset(nominal_logset)
    for a, b in zip(memory.runs, disk.runs):
        assert (a.name, a.use, a.controller) == (b.name, b.use, b.controller)
        np.testing.assert_array_equal(a.stack(*a.columns), b.stack(*b.columns))
    assert len(memory.sha256()) == len(disk.sha256()) == 64
    with pytest.raises(InputError, match=r"no table 'run0\.csv'.*other"):
        logset_from_frames(description(), {"other": frames["run0.csv"]})


def test_remarks_of_a_log_set_reach_its_notes(nominal_logset, tmp_path):
    document = {**description(), "remarks": ["resampled by hand"]}
    (tmp_path / "logset.yaml").write_text(yaml.safe_dump(document))
    for i in range(4):
        (tmp_path / f"run{i}.csv").symlink_to(nominal_logset / f"run{i}.csv")
    with pytest.raises(InputError, match="outside"):
        load_logset(tmp_path)
    frames = {run.name: run.columns for run in load_logset(nominal_logset).runs}
    assert logset_from_frames(document, frames).notes == ("resampled by hand",)
