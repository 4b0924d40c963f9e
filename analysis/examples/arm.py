"""The arm of ``own_robot`` and ``own_effect``: its equation of motion, and a log as it would be measured."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ..files import output_folder

DT, NOISE = 1e-3, 0.005  # sample time [s], of the torque signal [N m]
RUNS = ((0.8, 0.5, "fit"), (0.4, 1.0, "fit"), (0.6, 0.8, "validate"))  # [rad], [Hz], use


@dataclass
class Arm:
    """J q'' + m g l sin(q) + b q' + dry friction + cable k q = torque."""

    inertia: float = 0.05  # J [kg m^2]
    weight: float = 1.2  # m g l [N m]
    damping: float = 0.02  # b [N m s/rad]
    dry: float = 0.0  # level of dry friction [N m]
    cable: float = 0.0  # stiffness k of a cable [N m/rad]
    time: float = 0.0  # since it was switched on [s]

    def torque(self, q: Any, rate: Any, acceleration: Any) -> Any:
        """Torque [N m] of a motion, arrays of one shape."""
        drag = self.damping * rate + self.dry * np.tanh(rate / 0.05)
        return self.inertia * acceleration + self.weight * np.sin(q) + drag + self.cable * q

    def rub(self, values: Mapping[str, float]) -> None:
        """Add dry friction of ``level`` [N m]."""
        self.dry += values["level"]

    def finished(self) -> "Arm":
        """All effects have acted: nothing is left to do."""
        return self


def write_log(arm: Arm, folder: Path) -> None:
    """A log set of four cycles a run, as measured on ``arm``; what it hides is not in it."""
    entries, rng = [], np.random.default_rng(3)
    for i, (amplitude, rate_hz, use) in enumerate(RUNS, 1):
        t, w = np.arange(round(4.0 / rate_hz / DT)) * np.float64(DT), 2.0 * np.pi * rate_hz
        q, rate = amplitude * np.sin(w * t), amplitude * w * np.cos(w * t)
        torque = arm.torque(q, rate, -(w**2) * q) + NOISE * rng.normal(size=len(t))
        np.savetxt(output_folder(folder) / f"run{i}.csv", np.column_stack([t, q, torque]),
                   "%.9f", ",", header="t,q,tau", comments="")  # fmt: skip
        entries.append({"file": f"run{i}.csv", "rate_Hz": rate_hz, "use": use})
    content = {"format": 1, "name": "arm", "system": {"kind": "arm"}, "controller": {"kind": "by hand"}, "sample_time_s": DT,
               "columns": {"t": "s", "q": "rad", "tau": "N m"}, "runs": entries}  # fmt: skip
    (folder / "logset.yaml").write_text(yaml.safe_dump(content, sort_keys=False))
