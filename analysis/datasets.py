"""Public measured log sets by name: from a local folder or a mirror, every file checked by its hash."""

import os
import shutil
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from .errors import InputError
from .files import write_folder

VARIABLE = "GAPSCOPE_DATA"


def known_sets() -> dict[str, dict[str, Any]]:
    """Every set by name: ``source``, ``original`` (its address), ``license``, ``files`` (name -> SHA-256)."""
    text = (files(__package__ or "gapscope.analysis") / "datasets.yaml").read_text("utf-8")
    found: dict[str, dict[str, Any]] = yaml.safe_load(text)
    return found


def get(name: str, out: Path, *, url: str | None = None) -> list[Path]:
    """Put the log set ``name`` into the folder ``out``, all files or none, and return its files.

    It is downloaded from ``url``/NAME/FILE by pooch, or copied from the folder that GAPSCOPE_DATA
    names. Raises InputError for an unknown name, a file whose hash differs, and where there is no source.
    """
    sets = known_sets()
    if name not in sets:
        raise InputError("data set", repr(name), f"one of {', '.join(sets)}")
    entry = sets[name]
    with TemporaryDirectory() as scratch:
        if url is not None:
            folder = _download(name, entry["files"], url, Path(scratch))
        else:
            folder = _local(name, entry)
            _check(folder, entry["files"])
        copies = {file: _copier(folder / file) for file in entry["files"]}
        return write_folder(out, copies)


def _copier(source: Path) -> Any:
    return lambda path: shutil.copyfile(source, path)


def _local(name: str, entry: Mapping[str, Any]) -> Path:
    root = os.environ.get(VARIABLE)
    if not root:
        raise InputError(
            name, "the converted tables of this log set have no public address",
            "a local folder or a mirror with them",
            f"`export {VARIABLE}=FOLDER` with FOLDER/{name}/{next(iter(entry['files']))} and so on, or name a mirror "
            f"by --url. Original: {entry['original']}. Source: {entry['source']}.",
        )  # fmt: skip
    folder = Path(root) / name
    if not folder.is_dir():
        raise InputError(folder, f"not there, though {VARIABLE} is set", f"the log set {name}")
    return folder


def _check(folder: Path, hashes: Mapping[str, str]) -> None:
    import hashlib

    for file, expected in hashes.items():
        path = folder / file
        if not path.is_file():
            raise InputError(path, "file not found", "a file of the log set")
        with open(path, "rb") as stream:
            found = hashlib.file_digest(stream, "sha256").hexdigest()
        if found != expected:
            raise InputError(path, f"SHA-256 {found}", expected, "The file is not the known one.")


def _download(name: str, hashes: Mapping[str, str], url: str, scratch: Path) -> Path:
    try:
        import pooch
    except ImportError:
        raise InputError(
            "--url", "pooch is not installed", "the optional extra 'data'",
            "Install it: pip install 'gapscope[data]'",
        ) from None  # fmt: skip
    pooch.get_logger().setLevel("WARNING")
    fetcher = pooch.create(
        path=scratch,
        base_url=f"{url.rstrip('/')}/{name}/",
        registry={file: f"sha256:{digest}" for file, digest in hashes.items()},
    )
    for file in hashes:
        try:
            fetcher.fetch(file)
        except (OSError, ValueError) as error:  # requests' errors are OSErrors
            raise InputError(
                f"{url.rstrip('/')}/{name}/{file}", str(error).splitlines()[0][:300],
                "a file with the known SHA-256",
                f"Without a connection, set {VARIABLE} to a folder that holds {name}/.",
            ) from None  # fmt: skip
    return scratch
