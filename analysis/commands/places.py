"""``--out`` of every command: refused before the work where nothing can be written."""

from pathlib import Path


def folder(out: Path | None) -> Path | None:
    """Callback of an option that names a folder: InputError unless it is or can be one; nothing is made."""
    from ..files import require_writable

    if out is not None:
        require_writable(out)
    return out


def file(out: Path | None) -> Path | None:
    """Callback of an option that names a file: InputError if it is a folder or its folder cannot be one."""
    from ..errors import InputError

    if out is not None and out.is_dir():
        raise InputError(out, "a folder", "a name for the file to write")
    folder(out and out.parent)
    return out


def beside(out: Path) -> Path:
    """Callback of an option that names a file or a folder, as another option says."""
    folder(out.parent)
    return out
