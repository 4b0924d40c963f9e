"""Blind check: an independent machine hides one effect, its answer is sealed, then diagnosed, then opened.

python -m gapscope.analysis.examples.blind FOLDER
"""

import hashlib
import sys
from pathlib import Path

from ..demo import SealedCase, named, sealed_case
from ..gap.diagnosis import diagnose
from ..gap.picture import shrinkage_picture
from ..gap.result import Diagnosis


def main(folder: Path, seed: int = 7) -> tuple[SealedCase, Diagnosis]:
    """Seal, diagnose, open; raises RuntimeError if the answer is not the one that was sealed."""
    folder.mkdir(parents=True, exist_ok=True)
    case = sealed_case(folder, seed)  # its SHA-256 is on disk before anybody diagnoses
    result = diagnose(case.logset)
    shrinkage_picture(result).savefig(folder / "blind.png", dpi=120)
    opened = case.open(folder)
    if hashlib.sha256(opened.read_bytes()).hexdigest() != case.seal:
        raise RuntimeError("the answer was changed after it had been sealed")
    return case, result


if __name__ == "__main__":
    case, result = main(Path(sys.argv[1]))
    sys.stdout.write(f"said {result.verdict.verdict} {', '.join(named(result))}; ")
    sys.stdout.write(f"true {', '.join(case.answer['answer'])}\n")
