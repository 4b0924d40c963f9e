"""Public data sets arrive whole with the known hash, or not at all."""

import functools
import hashlib
import http.server
import io
import os
import shutil
import threading
import zipfile
from pathlib import Path

import numpy as np
import pytest
import scipy.io

from gapscope.analysis import datasets
from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.logset import load_logset

FILES = {"logset.yaml": b"format: 1\n", "run.csv": b"t,q\n0,1\n"}


@pytest.fixture
def mirror(tmp_path, monkeypatch):
    """A folder with one set that the registry knows."""
    folder = tmp_path / "mirror" / "axis"
    folder.mkdir(parents=True)
    for name, content in FILES.items():
        (folder / name).write_bytes(content)
    hashes = {name: hashlib.sha256(content).hexdigest() for name, content in FILES.items()}
    original = "https://example.org/axis.zip"
    entry = {"source": "a paper", "original": original, "license": "none", "files": hashes}
    monkeypatch.setattr(datasets, "known_sets", lambda: {"axis": entry})
    monkeypatch.delenv(datasets.VARIABLE, raising=False)
    return folder.parent


@pytest.fixture
def server(mirror):
    class Quiet(http.server.SimpleHTTPRequestHandler):
        def log_message(self, *arguments):
            pass

    handler = functools.partial(Quiet, directory=str(mirror))
    with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as running:
        thread = threading.Thread(target=running.serve_forever)
        thread.start()
        yield f"http://127.0.0.1:{running.server_address[1]}"
        running.shutdown()
        thread.join()


def test_a_local_folder_is_copied(mirror, tmp_path, monkeypatch):
    monkeypatch.setenv(datasets.VARIABLE, str(mirror))
    paths = datasets.get("axis", tmp_path / "out")
    assert {p.name: p.read_bytes() for p in paths} == FILES


def test_a_mirror_is_downloaded(server, tmp_path):
    pytest.importorskip("pooch")
    paths = datasets.get("axis", tmp_path / "out", url=server)
    assert {p.name: p.read_bytes() for p in paths} == FILES


@pytest.mark.parametrize("remote", [False, True])
def test_a_changed_file_is_refused_and_nothing_is_written(
    remote, mirror, server, tmp_path, monkeypatch
):
    pytest.importorskip("pooch")
    (mirror / "axis" / "run.csv").write_bytes(b"t,q\n0,2\n")
    monkeypatch.setenv(datasets.VARIABLE, str(mirror))
    with pytest.raises(InputError, match=r"run\.csv"):
        datasets.get("axis", tmp_path / "out", url=server if remote else None)
    assert not (tmp_path / "out").exists()


def test_a_missing_file_on_the_mirror_is_one_error(mirror, server, tmp_path):
    pytest.importorskip("pooch")
    shutil.rmtree(mirror / "axis")
    with pytest.raises(InputError, match="404"):
        datasets.get("axis", tmp_path / "out", url=server)


def test_without_a_source_the_remedy_is_named(mirror, tmp_path):
    with pytest.raises(InputError, match=r"GAPSCOPE_DATA=FOLDER.*--url.*axis\.zip.*a paper"):
        datasets.get("axis", tmp_path / "out")
    with pytest.raises(InputError, match="one of axis"):
        datasets.get("axes", tmp_path / "out")
    with pytest.raises(InputError, match=r"how axis is made.*GAPSCOPE_DATA"):
        datasets.get("axis", tmp_path / "out", original=tmp_path / "axis.zip")


def published(variables, folder=""):
    """An archive with a .mat file, as EMPS is published."""
    mat, archive = io.BytesIO(), io.BytesIO()
    scipy.io.savemat(mat, {name: np.c_[values] for name, values in variables.items()})
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr(folder + "DATA_EMPS.mat", mat.getvalue())
    return archive.getvalue()


ROWS = range(100)
SMALL = {
    "t": [0.001 * k for k in ROWS], "qg": [1e-4 * k for k in ROWS], "qm": [5e-8 * k for k in ROWS],
    "vir": [0.5 * (-1) ** k for k in ROWS], "gtau": 35.0,
}  # fmt: skip
TABLE = "t,q_ref,q,u,force\n" + "".join(
    f"{0.001 * k:.4f},{1e-4 * k:.8f},{5e-8 * k:.8f},{(-1) ** k * 0.5:.6f},{(-1) ** k * 17.5753:.4f}\n"
    for k in ROWS
)


@pytest.fixture
def archived(mirror, server, monkeypatch):
    """The registry's own entry of EMPS, its archive on the server, the hash that of a small table."""
    monkeypatch.undo()
    entry = datasets.known_sets()["emps"]
    entry["archive"]["url"] = f"{server}/EMPS.zip"
    entry["files"]["train.csv"] = hashlib.sha256(TABLE.encode()).hexdigest()
    monkeypatch.setattr(datasets, "known_sets", lambda: {"emps": entry})
    monkeypatch.delenv(datasets.VARIABLE, raising=False)
    return mirror / "EMPS.zip"


def test_the_published_archive_becomes_the_log_set(archived, tmp_path):
    pytest.importorskip("pooch")
    archived.write_bytes(published(SMALL))
    for out, original in ((tmp_path / "a", None), (tmp_path / "b", archived)):
        paths = datasets.get("emps", out, original=original)
        assert (out / "train.csv").read_text() == TABLE
        assert [p.name for p in paths] == ["logset.yaml", "train.csv"]
        log = load_logset(out)
        assert log.system["nominal"]["mass_kg"] == 95.1089
        assert log.runs[0].columns["force"].tolist() == [17.5753, -17.5753] * 50


def test_another_archive_is_refused_and_nothing_is_written(archived, tmp_path):
    pytest.importorskip("pooch")
    out = tmp_path / "out"
    for content, message in (
        (published(SMALL | {"vir": SMALL["t"]}), "SHA-256"),
        (published({"t": SMALL["t"]}), "qg"),
        (b"<html>quota exceeded</html>", "no archive"),
        (zipped("other.mat"), r"no DATA_EMPS\.mat in it"),
    ):
        archived.write_bytes(content)
        with pytest.raises(InputError, match=message):
            datasets.get("emps", out)
        assert not out.exists()
    archived.unlink()
    with pytest.raises(InputError, match=r"404.*--original FILE.*GAPSCOPE_DATA.*--url"):
        datasets.get("emps", out)


def zipped(name):
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w") as file:
        file.writestr(name, b"")
    return content.getvalue()


@pytest.mark.skipif("GAPSCOPE_DATA" not in os.environ, reason="GAPSCOPE_DATA is not set")
def test_volts_that_round_to_the_known_table_give_its_hash(tmp_path):
    """The table's format is known to the last digit; the archive itself is not at hand."""
    known = Path(os.environ["GAPSCOPE_DATA"]) / "emps" / "train.csv"
    t, reference, position, volts, force = np.loadtxt(known, delimiter=",", skiprows=1).T
    gain = datasets.known_sets()["emps"]["archive"]["columns"]["force"][1]
    low = np.maximum(volts - 5e-7, (force - 5e-5) / gain)
    high = np.minimum(volts + 5e-7, (force + 5e-5) / gain)
    archive = tmp_path / "EMPS.zip"
    archive.write_bytes(published(
        {"t": t, "qg": reference, "qm": position, "vir": 0.5 * (low + high)}, "EMPS/"
    ))  # fmt: skip
    datasets.get("emps", tmp_path / "out", original=archive)
    assert (tmp_path / "out" / "train.csv").read_bytes() == known.read_bytes()


@pytest.mark.skipif("GAPSCOPE_DATA" not in os.environ, reason="GAPSCOPE_DATA is not set")
def test_measured_sets_here_are_those_the_registry_knows(tmp_path):
    for name in datasets.known_sets():
        assert datasets.get(name, tmp_path / name)
