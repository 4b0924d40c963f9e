"""Unusable log sets end in one clear error that names the place."""

import gzip
import shutil

import pytest
import yaml

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine


@pytest.fixture
def logset(nominal_logset, tmp_path):
    return shutil.copytree(nominal_logset, tmp_path / "set")


def edit(folder, change):
    path = folder / "logset.yaml"
    document = yaml.safe_load(path.read_text())
    change(document)
    path.write_text(yaml.safe_dump(document))


def edit_rows(folder, change, name="run0.csv"):
    path = folder / name
    rows = path.read_text().splitlines()
    path.write_text("\n".join(change(rows)) + "\n")


def replace_cell(rows, row, column, text):
    cells = rows[row].split(",")
    cells[column] = text
    return [*rows[:row], ",".join(cells), *rows[row + 1 :]]


def test_a_good_set_is_read(logset):
    log = load_logset(logset)
    assert (log.kind, len(log.fit), len(log.validate)) == ("c_drive", 3, 1)
    machine, runs = read_machine(log)
    assert machine.joints == ("left", "right")
    assert [run.period for run in runs] == [500] * 4


def test_gzipped_tables_are_read(logset):
    plain = logset / "run0.csv"
    with gzip.open(logset / "run0.csv.gz", "wb") as stream:
        stream.write(plain.read_bytes())
    plain.unlink()
    edit(logset, lambda d: d["runs"][0].update(file="run0.csv.gz"))
    assert load_logset(logset).runs[0].samples == 1500


def test_the_answer_of_a_labelled_set_is_not_kept(logset):
    edit(logset, lambda d: d.update(answer=["friction.coulomb"]))
    log = load_logset(logset)
    assert "friction.coulomb" not in repr({k: v for k, v in vars(log).items() if k != "runs"})


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda d: d.update(sampel_time=1), "sampel_time"),
        (lambda d: d.update(format=2), "format"),
        (lambda d: d.pop("runs"), "runs"),
        (lambda d: d["runs"][0].update(use="train"), "fit or validate"),
        (lambda d: d["runs"][0].update(controller="pid"), "pid"),
        (lambda d: d["runs"][0].update(file="../run0.csv"), "outside"),
        (lambda d: d["runs"][0].update(file="nope.csv"), "not found"),
        (lambda d: d["runs"][0].update(motion="spiral"), "spiral"),
        (lambda d: d["runs"][0].update(rate_Hz=-1), "rate_Hz"),
        (lambda d: d["system"].update(kind="hexapod"), "hexapod"),
        (lambda d: d["system"]["nominal"].update(beta_N_ms=1.0), "beta_N_ms"),
        (lambda d: d["system"]["nominal"].update(beta_N_m_s="big"), "beta_N_m_s"),
        (lambda d: d["system"].update(tolerance=3), "tolerance"),
        (lambda d: d["columns"].update(psi_L="deg"), "psi_L"),
        (lambda d: d["columns"].pop("tau_R"), "tau_R"),
        (lambda d: d["columns"].update(current="A"), "current"),
        (lambda d: d["controllers"]["pd"].update(kind="lqr"), "lqr"),
        (lambda d: d["controllers"]["pd"].pop("kp_Nm_per_rad"), "kp_Nm_per_rad"),
        (lambda d: d.update(sample_time_s=0.002), "sample_time_s"),
        (lambda d: [r.update(use="validate") for r in d["runs"]], "use: fit"),
    ],
)
def test_a_bad_key_is_named(logset, change, words):
    edit(logset, change)
    with pytest.raises(InputError, match=words):
        read_machine(load_logset(logset))


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda rows: replace_cell(rows, 7, 3, "nan"), "row 8, column psi_L"),
        (lambda rows: replace_cell(rows, 7, 3, "abc"), "unreadable"),
        (lambda rows: [*rows[:9], rows[8], *rows[9:]], "row 10, column t"),
        (lambda rows: replace_cell(rows, 500, 0, "0.4996"), "jitter"),
        (lambda rows: [*rows[:-1], rows[-1][:20]], "truncated|unreadable"),
        (lambda rows: rows[:50], "at least 100 rows"),
        (lambda rows: [rows[0].replace("psi_R,", "psi_r,", 1), *rows[1:]], "psi_R"),
        (lambda rows: [], "no column"),
    ],
)
def test_a_bad_table_is_named_by_file_row_and_column(logset, change, words):
    edit_rows(logset, change)
    with pytest.raises(InputError, match=words) as caught:
        load_logset(logset)
    assert "run0.csv" in str(caught.value)


def test_a_folder_without_a_log_set_says_so(tmp_path):
    with pytest.raises(InputError, match=r"logset\.yaml"):
        load_logset(tmp_path)


@pytest.mark.parametrize("text", ["", "a: [", "- 1\n- 2\n", "\x00", "a: " + "[" * 3000])
def test_a_broken_description_is_one_error(logset, text):
    (logset / "logset.yaml").write_text(text)
    with pytest.raises(InputError, match=r"logset\.yaml"):
        load_logset(logset)


def test_a_folder_that_may_not_be_looked_into_is_one_error(tmp_path, monkeypatch):
    def refuse(path):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("pathlib.Path.is_file", refuse)
    with pytest.raises(InputError, match=r"cannot be looked into \(Permission denied\)"):
        load_logset(tmp_path)
