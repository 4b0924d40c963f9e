"""Log sets made of a published file: the archive is opened, its columns become a table of known hash."""

import hashlib
import io
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from .errors import InputError
from .files import write_folder
from .gap import tables


def make(name: str, entry: Mapping[str, Any], file: Path, out: Path, scratch: Path) -> list[Path]:
    """Write the log set of the archive or member ``file`` into ``out``, all files or none; returns them.

    ``entry`` is the one of ``datasets.yaml``, with ``archive``. The table counts as the published one only if
    it has the hash under ``files``: InputError otherwise, as for a file that is not what ``archive`` says.
    """
    archive = entry["archive"]
    table = _table(_member(file, archive["member"], scratch), archive["columns"])
    expected, found = entry["files"][archive["table"]], hashlib.sha256(table).hexdigest()
    if found != expected:
        raise InputError(
            file, f"the table made of it has the SHA-256 {found}", expected,
            f"This is not the file that the log set {name} was made of, or it has been changed since.",
        )  # fmt: skip
    description = yaml.safe_dump(archive["description"], sort_keys=False).encode()
    return write_folder(
        out, {"logset.yaml": _writer(description), archive["table"]: _writer(table)}
    )


def _writer(content: bytes) -> Callable[[Path], object]:
    return lambda path: path.write_bytes(content)


def _member(file: Path, member: str, scratch: Path) -> Path:
    """``file`` itself or what a ZIP archive holds under the name of ``member``, in whatever folder."""
    if not file.is_file():
        raise InputError(file, "file not found", f"{member}, or the archive with it")
    if file.suffix == Path(member).suffix:
        return file
    found = scratch / member
    found.write_bytes(_unpacked(file, member))
    return found


def _unpacked(file: Path, member: str) -> bytes:
    try:
        with zipfile.ZipFile(file) as archive:
            inside = [n for n in archive.namelist() if Path(n).name == member]
            if not inside:
                raise InputError(file, f"no {member} in it", "the published archive")
            return archive.read(inside[0])
    # No archive or a broken one, one that cannot be read, one with a password, one of an unknown compression.
    except (zipfile.BadZipFile, zlib.error, OSError, RuntimeError, NotImplementedError) as error:
        raise InputError(file, f"no archive ({error})", f"a ZIP file with {member}") from None


def _table(path: Path, columns: Mapping[str, tuple[str, float, int]]) -> bytes:
    variables = list(dict.fromkeys(variable for variable, _, _ in columns.values()))
    data = np.concatenate(list(tables.blocks(path, variables)))
    made = [factor * data[:, variables.index(variable)] for variable, factor, _ in columns.values()]
    text = io.StringIO()
    np.savetxt(
        text, np.column_stack(made), delimiter=",", header=",".join(columns), comments="",
        fmt=[f"%.{decimals}f" for _, _, decimals in columns.values()],
    )  # fmt: skip
    return text.getvalue().encode()
