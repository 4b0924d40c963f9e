"""Finished runs as log sets: one folder per configuration, each file written whole."""

import io
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ..files import output_folder, write_whole
from .machine import RigMachine, Trajectory, WithFiles


class Recorder:
    """Writes runs into ``folder``/measurement1, and a new folder after the settings have changed."""

    def __init__(self, folder: Path) -> None:
        self.folder = output_folder(folder)
        self._document: dict[str, Any] | None = None
        self._files: dict[str, str] = {}
        self._runs: list[dict[str, Any]] = []
        self._logset = self.folder

    def keep(
        self,
        machine: RigMachine,
        trajectory: Trajectory,
        rows: Sequence[Sequence[float]],
        use: str,
    ) -> Path:
        """Add one run; returns its file."""
        document = machine.document()
        files = dict(machine.files()) if isinstance(machine, WithFiles) else {}
        if (document, files) != (self._document, self._files):
            self._document, self._files, self._runs = document, files, []
            self._logset = output_folder(self.folder / f"measurement{self._next()}")
            for name, text in files.items():
                write_whole(self._logset / name, text)
        path = self._logset / f"run{len(self._runs) + 1}.csv"
        columns = machine.columns()
        write_whole(path, _csv(list(columns), rows))
        self._runs.append({"file": path.name, **trajectory.keys, "use": use})
        write_whole(self._logset / "logset.yaml", self._text(machine, columns))
        return path

    def summary(self) -> dict[str, Any]:
        """Folder and runs of the present log set."""
        return {"folder": str(self._logset), "runs": [dict(run) for run in self._runs]}

    def _next(self) -> int:
        numbers = [
            int(path.name.removeprefix("measurement"))
            for path in self.folder.glob("measurement*")
            if path.name.removeprefix("measurement").isdigit()
        ]
        return max(numbers, default=0) + 1

    def _text(self, machine: RigMachine, columns: Mapping[str, str]) -> str:
        assert self._document is not None
        content = {
            "format": 1,
            "name": self._logset.name,
            "source": f"gapscope rig, {machine.layout.kind}",
            **self._document,
            "columns": dict(columns),
            "runs": self._runs,
        }
        return yaml.safe_dump(content, sort_keys=False)


def _csv(names: Sequence[str], rows: Sequence[Sequence[float]]) -> str:
    text = io.StringIO()
    table = np.asarray(rows, dtype=float)
    np.savetxt(text, table, delimiter=",", header=",".join(names), comments="",
               fmt=["%.6f"] + ["%.10g"] * (table.shape[1] - 1))  # fmt: skip
    return text.getvalue()
