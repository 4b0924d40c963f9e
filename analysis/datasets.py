"""Public measured log sets by name: a local folder, a mirror or the published file, checked by hashes."""

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


def get(
    name: str, out: Path, *, url: str | None = None, original: Path | None = None
) -> list[Path]:
    """Put the log set ``name`` into the folder ``out``, all files or none, and return its files.

    Made of the published file ``original``; else downloaded from ``url``/NAME/FILE by pooch; else copied from the
    folder that GAPSCOPE_DATA names; else, where the registry knows an archive, made of its download. Raises
    InputError for an unknown name, a file whose hash differs, and where there is no source.
    """
    sets = known_sets()
    if name not in sets:
        raise InputError("data set", repr(name), f"one of {', '.join(sets)}")
    entry = sets[name]
    if original is not None and url is not None:
        raise InputError("--original and --url", "both given", "one source")
    with TemporaryDirectory() as temporary:
        scratch = Path(temporary)
        if original is None and url is None and not os.environ.get(VARIABLE):
            original = _published(name, entry, scratch)
        if original is not None:
            return _made(name, entry, original, out, scratch)
        if url is not None:
            folder = _download(name, entry["files"], url, scratch)
        else:
            folder = _local(name)
            _check(folder, entry["files"])
        copies = {file: _copier(folder / file) for file in entry["files"]}
        return write_folder(out, copies)


def _made(name: str, entry: Mapping[str, Any], file: Path, out: Path, scratch: Path) -> list[Path]:
    from .originals import make

    if "archive" not in entry:
        raise InputError(
            "--original", f"how {name} is made of its original is not known", "a folder or a mirror",
            _remedy(name, entry),
        )  # fmt: skip
    return make(name, entry, file, out, scratch)


def _copier(source: Path) -> Any:
    return lambda path: shutil.copyfile(source, path)


def _remedy(name: str, entry: Mapping[str, Any]) -> str:
    return (
        f"`export {VARIABLE}=FOLDER` with FOLDER/{name}/{next(iter(entry['files']))} and so on, or name a mirror "
        f"by --url. Original: {entry['original']}. Source: {entry['source']}."
    )


def _local(name: str) -> Path:
    folder = Path(os.environ[VARIABLE]) / name
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


def _published(name: str, entry: Mapping[str, Any], scratch: Path) -> Path:
    """The archive of a set, downloaded."""
    if "archive" not in entry:
        raise InputError(
            name, "the converted tables of this log set have no public address",
            "a local folder or a mirror with them", _remedy(name, entry),
        )  # fmt: skip
    address = entry["archive"]["url"]
    pooch = _pooch()
    try:
        # No hash of the archive is published; that of the table made of it is checked.
        found = pooch.retrieve(address, known_hash=None, fname=f"{name}.zip", path=scratch)
    except (OSError, ValueError) as error:  # requests' errors are OSErrors
        raise InputError(
            address, _first_line(error), f"the original of {name}",
            f"Fetch it by other means and name it by --original FILE, or {_remedy(name, entry)}",
        ) from None  # fmt: skip
    return Path(found)


def _first_line(error: Exception) -> str:
    return str(error).splitlines()[0][:300]


def _pooch() -> Any:
    try:
        import pooch
    except ImportError:
        raise InputError(
            "download", "pooch is not installed", "the optional extra 'data'",
            "Install it: pip install 'gapscope[data]'",
        ) from None  # fmt: skip
    pooch.get_logger().setLevel("WARNING")
    return pooch


def _download(name: str, hashes: Mapping[str, str], url: str, scratch: Path) -> Path:
    fetcher = _pooch().create(
        path=scratch,
        base_url=f"{url.rstrip('/')}/{name}/",
        registry={file: f"sha256:{digest}" for file, digest in hashes.items()},
    )
    for file in hashes:
        try:
            fetcher.fetch(file)
        except (OSError, ValueError) as error:  # requests' errors are OSErrors
            raise InputError(
                f"{url.rstrip('/')}/{name}/{file}", _first_line(error),
                "a file with the known SHA-256",
                f"Without a connection, set {VARIABLE} to a folder that holds {name}/.",
            ) from None  # fmt: skip
    return scratch
