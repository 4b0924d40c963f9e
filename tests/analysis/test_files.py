"""Results are written whole or not at all."""

from pathlib import Path

import pytest

from gapscope.analysis import files
from gapscope.analysis.errors import InputError


def test_a_failed_write_leaves_the_old_file_and_nothing_else(tmp_path):
    path = tmp_path / "result.json"
    files.write_whole(path, "old")
    with pytest.raises(UnicodeEncodeError):
        files.write_whole(path, "\ud800")
    with pytest.raises(TypeError):
        files.write_whole(path, 3)
    (tmp_path / "folder").mkdir()
    with pytest.raises(InputError, match="folder: Is a directory"):
        files.write_whole(tmp_path / "folder", "new")
    (tmp_path / "folder").rmdir()
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_file_is_no_output_folder(tmp_path):
    (tmp_path / "taken").write_text("")
    for path in (tmp_path / "taken", tmp_path / "taken" / "below"):
        with pytest.raises(InputError, match="not usable as a folder"):
            files.output_folder(path)
        with pytest.raises(InputError, match="not usable as a folder"):
            files.require_writable(path)


def test_whether_a_folder_can_be_written_is_asked_without_making_it(tmp_path):
    files.require_writable(tmp_path)
    files.require_writable(tmp_path / "new" / "below")
    assert not list(tmp_path.iterdir())
    closed = Path("/proc")  # where not even root can write
    if closed.is_dir():
        with pytest.raises(InputError, match="not usable as a folder"):
            files.require_writable(closed / "new")
