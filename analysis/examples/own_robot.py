"""Your own robot: an arm under gravity becomes a kind of log set that the instrument can diagnose.

python -m gapscope.analysis.examples.own_robot FOLDER
"""

import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ..gap.diagnosis import Diagnosis, diagnose
from ..gap.effects import Form, parameter
from ..gap.machine import Array, Machine, RunData, rms
from ..gap.machines import KINDS
from ..gap.picture import shrinkage_picture
from .arm import Arm, write_log
from .arm_runs import read


class ArmMachine(Machine):
    """How an arm is built, and predicted: by the torque that a logged motion needs."""

    residual_unit = "N m"

    def build(self, values: Mapping[str, float]) -> Arm:
        """An arm with these values of its own parameters."""
        return Arm(**values)

    def predict(self, run: RunData, plant: Arm) -> Array:
        """Torque of the model less that of the log."""
        rate = np.gradient(run.position, run.dt, axis=0)
        torque = plant.torque(run.position, rate, np.gradient(rate, run.dt, axis=0))
        return (np.asarray(torque) - run.command)[run.window]

    def forms(self, runs: Sequence[RunData]) -> list[Form]:
        """What may be wrong with an arm; ``own_effect.py`` adds to it."""
        what: dict[str, Any] = {"effect": "friction.coulomb", "name": "tanh", "apply": Arm.rub}
        levels = (parameter("level", "N m", 0.1, lower=0.0, starts=(0.05,)),)
        return [Form(**what, parameters=levels, where=lambda names: {"elements": ["bearing"]})]

    def spread(self, runs: Sequence[RunData]) -> float:
        """Rms torque [N m]: a prediction that errs by more explains nothing."""
        return rms([run.command[run.window] for run in runs])


def main(folder: Path) -> Diagnosis:
    """Measure an arm whose bearing rubs, let the instrument find that, and draw the result."""
    KINDS["arm"] = partial(read, machine=ArmMachine)
    write_log(Arm(dry=0.1), folder)
    result = diagnose(folder)
    shrinkage_picture(result).savefig(folder / "own_robot.png", dpi=120)
    return result


if __name__ == "__main__":
    sys.stdout.write(main(Path(sys.argv[1])).verdict.reason + "\n")
