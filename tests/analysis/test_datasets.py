"""Public data sets arrive whole with the known hash, or not at all."""

import functools
import hashlib
import http.server
import os
import shutil
import threading

import pytest

from gapscope.analysis import datasets
from gapscope.analysis.errors import InputError

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


@pytest.mark.skipif("GAPSCOPE_DATA" not in os.environ, reason="GAPSCOPE_DATA is not set")
def test_measured_sets_here_are_those_the_registry_knows(tmp_path):
    for name in datasets.known_sets():
        assert datasets.get(name, tmp_path / name)
