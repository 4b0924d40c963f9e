"""First diagnosis: simulate a C-drive with unknown friction, then let the instrument find it.

python -m gapscope.analysis.examples.first_diagnosis FOLDER
"""

import sys
from pathlib import Path

import numpy as np
import yaml

from ...diagrams.c_drive_config import CDriveLoopConfig
from ..gap.diagnosis import diagnose
from ..gap.picture import shrinkage_picture
from ..gap.result import Diagnosis
from ..simulation import simulate_c_drive, write_c_drive_run

MOTIONS = ("translation", "rotation", "helical")


def main(folder: Path) -> Diagnosis:
    """Write a log set of a machine with Coulomb friction and diagnose it."""
    entries = []
    for motion in MOTIONS:
        config = CDriveLoopConfig(motion=motion, rate=2.0, cycles=3)
        config.machine.delta = 0.15  # what the diagnosis is not told [N m]
        write_c_drive_run(simulate_c_drive(config), folder / motion)
        description = yaml.safe_load((folder / motion / "logset.yaml").read_text())
        (folder / motion / "run1.csv").replace(folder / f"{motion}.csv")
        use = "validate" if motion == "helical" else "fit"
        entries.append({**description["runs"][0], "file": f"{motion}.csv", "use": use})
    description["system"]["nominal"]["delta_N_m"] = 0.0  # the nominal model knows no dry friction
    description.update(name="first diagnosis", runs=entries)
    (folder / "logset.yaml").write_text(yaml.safe_dump(description, sort_keys=False))
    result = diagnose(folder)
    result.save(folder)
    shrinkage_picture(result).savefig(folder / "first_diagnosis.png", dpi=120)
    return result


if __name__ == "__main__":
    found = main(Path(sys.argv[1])).to_json()
    sys.stdout.write(f"{found['verdict']}: {found['reason']}\n")
    for effect in found["effects"]:
        levels = [v["value"] for k, v in effect["parameters"].items() if k.startswith("level")]
        sys.stdout.write(f"{effect['id']} at {effect['where']}: {np.round(levels, 3)} N m\n")
