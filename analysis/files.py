"""Results on disk: written whole or not at all."""

import os
import re
import shutil
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from .errors import InputError

DRAFT = ".gapscope-"  # start of the name of a folder that is being written
# Name of a file that is being written.
DRAFT_FILE = re.compile(r"\..+\.(json|html|md|png|csv|yaml)\.[a-z0-9_]{8}")


def require_writable(path: Path) -> None:
    """InputError unless ``path`` is a folder, or can be made one, where files can be written.

    Tried with a draft in the folder or in the nearest one above it that exists; nothing is left behind.
    """
    try:
        place = next((p for p in (path, *path.parents) if p.exists()), Path())
        with tempfile.TemporaryDirectory(dir=place, prefix=DRAFT):
            pass
    except OSError as error:
        raise _unusable(path, error) from error


def output_folder(path: Path) -> Path:
    """``path`` as an existing folder; InputError if it is a file or cannot be made."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _unusable(path, error) from error
    return path


def _unusable(path: Path, error: OSError) -> InputError:
    return InputError(
        path,
        f"not usable as a folder ({error.strerror or error})",
        "a folder that can be written, or a name for a new one",
    )


def write_whole(path: Path, content: str | bytes) -> None:
    """Write ``content`` to a temporary file beside ``path``, then put it in its place.

    InputError if that cannot be done, as on a full disk; what stood there is left as it was.
    """
    data = content.encode() if isinstance(content, str) else content
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
        temporary = Path(name)
        try:
            with os.fdopen(handle, "wb") as file:
                file.write(data)
            temporary.chmod(0o644)
            temporary.replace(path)
        except BaseException:
            temporary.unlink(missing_ok=True)
            raise
    except OSError as error:
        raise InputError(
            path, error.strerror or str(error), "a place where a file can be written"
        ) from error


def drop_drafts(folder: Path) -> None:
    """Remove what ``write_whole`` and ``write_folder`` left in ``folder`` when they were killed."""
    for draft in folder.glob(".*"):
        if draft.name.startswith(DRAFT) and draft.is_dir():
            shutil.rmtree(draft, ignore_errors=True)
        elif draft.is_file() and DRAFT_FILE.fullmatch(draft.name):
            draft.unlink(missing_ok=True)


def write_folder(out: Path, files: Mapping[str, Callable[[Path], Any]]) -> list[Path]:
    """Write each file by its function, then move all of them into the folder ``out``.

    The files are written beside their place first; if one fails, ``out`` is left as it was. Raises
    InputError if ``out`` is a file or cannot be written.
    """
    created = not out.exists()
    output_folder(out)
    try:
        with tempfile.TemporaryDirectory(dir=out, prefix=DRAFT) as draft:
            for name, write in files.items():
                write(Path(draft) / name)
            for name in files:
                os.replace(Path(draft) / name, out / name)
    except OSError as error:
        raise InputError(
            out, error.strerror or str(error), "a folder that can be written"
        ) from None
    except BaseException:
        if created and out.is_dir() and not any(out.iterdir()):
            out.rmdir()
        raise
    return [out / name for name in files]
