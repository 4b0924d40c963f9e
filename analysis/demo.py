"""``gapscope demo``: a printed experiment, a machine whose effect is withheld, a measured log.

1. the experiment printed by Friedlaender 2015, from its tables;
2. a C-drive of ``blind_machine`` with one effect that its seed decides. The answer is sealed by a
   SHA-256 before the diagnosis and opened after it;
3. where the environment variable GAPSCOPE_DATA names a folder with the EMPS log set, that log.
"""

import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from . import blind_machine
from .blind_machine.case import SINGLE
from .files import output_folder, write_whole
from .gap.report import write_report
from .gap.result import Diagnosis

DATA = "GAPSCOPE_DATA"
EMPS = "emps"  # folder of the log set inside it
SEED = 2015  # of the blind machine
CASES = 40  # a deck of the blind machine holds every effect once


@dataclass(frozen=True, kw_only=True)
class SealedCase:
    """A log set and its answer, whose SHA-256 is known before the diagnosis."""

    logset: Path
    seal: str
    answer: Mapping[str, Any]

    def right(self, diagnosis: Diagnosis) -> bool:
        """Whether the diagnosis explained the log with the true effects and no other."""
        explained = diagnosis.verdict.verdict == "explained"
        return explained and set(named(diagnosis)) == set(self.answer["answer"])

    def open(self, folder: Path) -> Path:
        """Write the answer into the folder; its SHA-256 is the seal."""
        path = folder / "answer.json"
        write_whole(path, _text(self.answer))
        return path


def named(diagnosis: Diagnosis) -> tuple[str, ...]:
    """Effects that a diagnosis accepted."""
    return tuple(effect["id"] for effect in diagnosis.to_json()["effects"])


def sealed_case(folder: Path, seed: int = SEED) -> SealedCase:
    """Simulate the first case of the seed that has one effect; write log set and seal.

    The log set does not hold the answer: a diagnosis that is given its folder has no way to know.
    """
    index = next(i for i in range(CASES) if blind_machine.draw(seed, i).kind == SINGLE)
    logset = output_folder(folder / "logset")
    answer = json.loads(json.dumps(blind_machine.write_case(seed, index, logset)))
    seal = hashlib.sha256(_text(answer).encode()).hexdigest()
    write_whole(folder / "sealed.sha256", f"{seal}  answer.json\n")
    return SealedCase(logset=logset, seal=seal, answer=answer)


def _text(answer: Mapping[str, Any]) -> str:
    return json.dumps(answer, indent=1) + "\n"


def measured_log() -> Path | None:
    """Folder of the measured EMPS log set; None where the data are not at hand."""
    data = os.environ.get(DATA)
    folder = Path(data) / EMPS if data else None
    return folder if folder is not None and (folder / "logset.yaml").is_file() else None


def save(result: Diagnosis, folder: Path) -> Path:
    """Write ``diagnosis.json`` and ``report.html``; returns the latter."""
    result.save(folder)
    return write_report(result, folder)
