"""Writing results: a set of files appears complete or not at all."""

import os
import tempfile
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from .errors import InputError


def write_folder(out: Path, files: Mapping[str, Callable[[Path], Any]]) -> list[Path]:
    """Write each file by its function, then move all of them into the folder ``out``.

    The files are written beside their place first; if one fails, ``out`` is left as it was. Raises
    InputError if ``out`` is a file or cannot be written.
    """
    created = not out.exists()
    try:
        out.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=out, prefix=".gapscope-") as draft:
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
