"""Your own effect: a cable that pulls the arm back, which no catalogue has, competes with friction.

python -m gapscope.analysis.examples.own_effect FOLDER
"""

import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path

from ..gap.diagnosis import diagnose
from ..gap.effects import Form, parameter
from ..gap.machine import RunData
from ..gap.machines import KINDS
from ..gap.picture import shrinkage_picture
from ..gap.result import Diagnosis
from .arm import Arm, write_log
from .arm_runs import read
from .own_robot import ArmMachine


def cable_form() -> Form:
    """A torque proportional to the angle; zero stiffness is no effect."""

    def apply(plant: Arm, values: Mapping[str, float]) -> None:
        plant.cable += values["stiffness"]

    return Form(
        effect="cable.stiffness",
        name="linear",
        parameters=(parameter("stiffness", "N m/rad", 0.2),),
        apply=apply,
        where=lambda names: {"joints": ["arm"]},
    )


class CabledArm(ArmMachine):
    """The arm of ``own_robot.py``, on which a cable may pull."""

    def forms(self, runs: Sequence[RunData]) -> list[Form]:
        """One form more."""
        return [*super().forms(runs), cable_form()]


def main(folder: Path) -> Diagnosis:
    """Measure an arm with a cable, diagnose, and draw how far the gap shrinks."""
    KINDS["arm"] = partial(read, machine=CabledArm)
    write_log(Arm(cable=0.3), folder)
    result = diagnose(folder)
    shrinkage_picture(result).savefig(folder / "own_effect.png", dpi=120)
    return result


if __name__ == "__main__":
    sys.stdout.write(main(Path(sys.argv[1])).verdict.reason + "\n")
