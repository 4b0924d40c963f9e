"""Log sets of the PepperMill-Carrier: what the controller computer knows, as ``gapscope diagnose`` reads it."""

import io
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from ...diagrams.pmc_loop import PMCLoopConfig
from ...models.pmc import constants
from ...models.pmc.parameters import PMCParameters
from ...models.pmc.prediction import MOTORS
from ...models.pmc.simulation import Reference
from ..files import output_folder, write_whole

Floats = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class LoggedRun:
    """One run; arrays (samples, 4), motors (L1, R1, L2, R2)."""

    file: str
    use: str  # fit or validate
    config: PMCLoopConfig
    reference: Reference
    measured: Floats  # motor angles from home [rad]
    command: Floats  # motor torques [N m]


def write(
    folder: Path,
    name: str,
    runs: Sequence[LoggedRun],
    nominal: PMCParameters,
    home: Floats,
    **more: Any,
) -> None:
    """Write ``logset.yaml`` and a table a run; the motor angles of all runs count from joints ``home`` (4,).

    ``more`` are further keys of the description. All runs have the controller of the first one.
    """
    into = output_folder(folder)
    for run in runs:
        write_whole(into / run.file, table(run, nominal, home))
    write_whole(into / "logset.yaml", description(name, runs, nominal, home, **more))


def table(run: LoggedRun, nominal: PMCParameters, home: Floats) -> str:
    """CSV of one run."""
    wanted = (run.reference.joints - home) @ constants.motor_map(nominal.drive.lead).T
    columns = {"t": run.reference.time}
    for i, motor in enumerate(MOTORS):
        columns[f"psi_{motor}_ref"] = wanted[:, i]
        columns[f"psi_{motor}"] = run.measured[:, i]
        columns[f"tau_{motor}"] = run.command[:, i]
    text = io.StringIO()
    np.savetxt(
        text,
        np.column_stack(list(columns.values())),
        delimiter=",",
        header=",".join(columns),
        comments="",
        fmt="%.9g",
    )
    return text.getvalue()


def description(
    name: str, runs: Sequence[LoggedRun], nominal: PMCParameters, home: Floats, **more: Any
) -> str:
    """``logset.yaml``."""
    config = runs[0].config
    units = {"t": "s"}
    for motor in MOTORS:
        units |= {f"psi_{motor}_ref": "rad", f"psi_{motor}": "rad", f"tau_{motor}": "N m"}
    content: dict[str, Any] = {
        "format": 1,
        "name": name,
        "system": {
            "kind": "pmc",
            "nominal": asdict(nominal),
            "home": [float(value) for value in home],
        },
        "controller": {
            "kind": config.controller,
            **asdict(config.settings()),
            "model_error": config.model_error,
        },
        "sample_time_s": config.sample_time,
        "columns": units,
        "runs": [_entry(run, nominal) for run in runs],
        **more,
    }
    # Tuples become lists: YAML's safe readers refuse Python tuples.
    return yaml.safe_dump(_lists(content), sort_keys=False)


def _entry(run: LoggedRun, nominal: PMCParameters) -> dict[str, Any]:
    return {
        "file": run.file,
        "use": run.use,
        "motion": run.config.cycle,
        "speed": run.config.speed,
        "placement": asdict(run.config.placement),
        "period_s": run.config.motion(nominal).period,
    }


def _lists(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _lists(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [_lists(item) for item in value]
    return value
