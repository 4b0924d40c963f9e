"""Next experiment: two gentle runs leave two causes open, designed motions tell which it is.

python -m gapscope.analysis.examples.next_experiment FOLDER
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ...models.fourier_motion import FourierMotion
from ...models.motion import MotionProgram, c_drive_motion
from ..blind_machine import any_motion, c_drive, drive_logset
from ..gap.design import Design, design_experiment
from ..gap.diagnosis import Diagnosis, diagnose

HIDDEN = c_drive.Machine()._replace(lag=1e-3)  # what the instrument is not told [s]
GENTLE = (("translation", 1.0, "fit"), ("translation", 0.8, "validate"))


def main(folder: Path, rounds: int = 2) -> tuple[list[Diagnosis], list[Design]]:
    """Diagnose gentle runs; while ambiguous, design a motion, run it on the machine, diagnose again."""
    folder.mkdir(parents=True, exist_ok=True)
    runs: list[dict[str, Any]] = []
    for motion, rate, use in GENTLE:
        program = c_drive_motion(motion, rate)
        _record(folder, runs, program, {"motion": motion, "rate_Hz": rate, "use": use})
    found, designs = [diagnose(folder)], list[Design]()
    while found[-1].verdict.verdict == "ambiguous" and len(designs) < rounds:
        design = design_experiment(found[-1])
        design.save(folder / f"design{len(designs) + 1}")  # with its picture design.png
        designs.append(design)
        for use in ("fit", "validate"):
            _record(folder, runs, design.motion, {"period_s": design.motion.period, "use": use})
        found.append(diagnose(folder))
    return found, designs


def _record(
    folder: Path,
    runs: list[dict[str, Any]],
    program: MotionProgram | FourierMotion,
    keys: dict[str, Any],
) -> None:
    """Three cycles of the hidden machine under PD, added to the log set in the folder."""
    t = np.arange(round(3.0 / program.rate / 1e-3)) * np.float64(1e-3)
    pd = drive_logset.STIFF["pd"]
    rows = any_motion.table(HIDDEN, pd, t, *program.sample(t)[::2], seed=len(runs))
    runs.append({"file": f"run{len(runs) + 1}.csv", "controller": "pd", **keys})
    (folder / runs[-1]["file"]).write_text(any_motion.csv(rows))
    text = any_motion.description("next experiment", runs)
    (folder / "logset.yaml").write_text(yaml.safe_dump(text))


if __name__ == "__main__":
    for found in main(Path(sys.argv[1]))[0]:
        sys.stdout.write(f"{found.verdict.verdict}: {found.verdict.reason}\n")
