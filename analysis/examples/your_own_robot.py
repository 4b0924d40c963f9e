"""Your own robot: a model file, a few logs, and what the model lacks.

python -m gapscope.analysis.examples.your_own_robot FOLDER

The "robot" is ``models/two_joint_arm.sdf`` in Drake's Simulator with dry friction in the shoulder that
the file does not have. What you need for yours is the folder this writes: the model file, one table a
run, and a ``logset.yaml`` (see ``analysis/gap/machines/README.md``).
"""

import sys
from pathlib import Path

from ..gap.diagnosis import diagnose
from ..gap.picture import shrinkage_picture
from ..gap.result import Diagnosis
from ..two_joint_robot import record

HIDDEN = (0.4, 0.0)  # dry friction of shoulder and elbow that the model file lacks [N m]


def main(folder: Path) -> Diagnosis:
    """Record the arm, diagnose it, and save ``diagnosis.json`` and a picture beside the logs."""
    found = diagnose(record(folder, friction=HIDDEN))
    sys.stdout.write(f"{found.verdict.verdict}: {found.verdict.reason}\n")
    for effect in found.to_json()["effects"]:
        sys.stdout.write(f"  {effect['id']} at {effect['where']}\n")
        for name, p in effect["parameters"].items():
            sys.stdout.write(f"    {name} = {p['value']:.3g} {p['unit']}\n")
    found.save(folder)
    shrinkage_picture(found).savefig(folder / "your_own_robot.png", dpi=120)
    return found


if __name__ == "__main__":
    main(Path(sys.argv[1]))
