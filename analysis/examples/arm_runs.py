"""How the instrument reads a log set of the arm."""

import numpy as np

from ..gap.logset import LogSet
from ..gap.machine import Machine, RunData, own_parameter
from .arm import Arm

OWN = {"inertia": "kg m^2", "weight": "N m", "damping": "N m s/rad"}


def read(log: LogSet, machine: type[Machine]) -> tuple[Machine, list[RunData]]:
    """Nominal machine, its parameters known to 3 %, and the runs."""
    runs = []
    for run in log.runs:
        q, rate_hz = run.stack("q"), float(run.settings["rate_Hz"])
        rate = np.gradient(q, log.dt, axis=0)
        runs.append(
            RunData(
                name=run.name,
                use=run.use,
                settings=run.settings,
                dt=log.dt,
                t=run.columns["t"],
                reference=q,
                reference_rate=rate,
                reference_acceleration=np.asarray(np.gradient(rate, log.dt, axis=0)),
                position=q,
                command=run.stack("tau"),
                controller=None,
                period=round(1.0 / (rate_hz * log.dt)),
                lsb=0.0,
            )
        )
    own = tuple(own_parameter(name, unit, getattr(Arm, name), 0.03) for name, unit in OWN.items())
    nominal = machine(kind="arm", joints=("arm",), position_unit="rad", effort_unit="N m", own=own)
    return nominal, runs
