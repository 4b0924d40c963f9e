"""Results on disk: written whole or not at all."""

import os
import tempfile
from pathlib import Path

from .errors import InputError


def output_folder(path: Path) -> Path:
    """``path`` as an existing folder; InputError if it is a file or cannot be made."""
    try:
        path.mkdir(parents=True, exist_ok=True)
    except (FileExistsError, NotADirectoryError, PermissionError) as error:
        raise InputError(
            path, f"not usable as a folder ({error.strerror})", "a folder, or a name for a new one"
        ) from error
    return path


def write_whole(path: Path, content: str | bytes) -> None:
    """Write ``content`` to a temporary file beside ``path``, then put it in its place."""
    data = content.encode() if isinstance(content, str) else content
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
