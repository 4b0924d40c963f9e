"""``gapscope simulate pmc``: run the Diagram, write its log as a log set, a figure and a 3-D replay."""

import io
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from ...diagrams.pmc_loop import PMCLoopConfig, pmc_loop
from ...models.pmc import constants, kinematics
from ...models.pmc.simulation import Run, sample_cycle
from ..errors import InputError
from ..files import output_folder, write_whole

Floats = NDArray[np.float64]
MOTORS = ("L1", "R1", "L2", "R2")


def run_diagram(
    config: PMCLoopConfig,
    cycles: float,
    progress: Callable[[float, float], None] = lambda done, total: None,
) -> Run:
    """Simulate the Diagram for some cycles. InputError if the robot leaves its working branch."""
    from pydrake.systems.analysis import Simulator

    diagram = pmc_loop(config)
    machine = config.machine()
    reference = sample_cycle(
        config.motion(machine), machine, cycles=cycles, sample_time=config.sample_time
    )
    simulator = Simulator(diagram)
    simulator.Initialize()
    context = simulator.get_context()
    names = ("joints", "rates", "measured", "command")
    ports = [diagram.GetOutputPort(name) for name in names]
    logged = np.empty((len(ports), len(reference.time), 4))
    for k, t in enumerate(reference.time):
        # Between samples the ports show what the next update will use.
        simulator.AdvanceTo(t)
        logged[:, k] = np.array([port.Eval(context) for port in ports])
        if not np.isfinite(logged[:, k]).all():
            raise InputError(
                f"{config.controller} on the {config.cycle} cycle",
                f"the robot left its working branch at t = {t:.3f} s",
                "a loop that stays in reach",
                "Try a slower cycle, a larger torque limit, or the counterweight.",
            )
        if k % 100 == 0:
            progress(float(t), float(reference.time[-1]))
    progress(float(reference.time[-1]), float(reference.time[-1]))
    joints, rates, measured, command = logged
    return Run(reference, joints, rates, measured, command, machine)


def simulate(
    config: PMCLoopConfig,
    out: Path,
    *,
    cycles: float = 1.0,
    replay: bool = True,
    progress: Callable[[float, float], None] = lambda done, total: None,
) -> Run:
    """Run and write ``logset.yaml``, ``run.csv.gz``, ``run.png`` and ``replay.html`` into ``out``."""
    from ...diagrams.pmc_view import replay_html
    from . import run_plot

    folder = output_folder(out)
    try:
        run = run_diagram(config, cycles, progress)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(
            "simulate pmc", str(error), "settings that a loop can be built with"
        ) from error
    table, units = log_table(run)
    write_whole(folder / "run.csv", table)
    write_whole(folder / "logset.yaml", log_set(run, config, units))
    write_whole(folder / "run.png", run_plot.png(run, config))
    if replay:
        page = replay_html(
            run.reference.time, run.joints, run.parameters, reference=run.reference.poses
        )
        write_whole(folder / "replay.html", page)
    return run


def log_table(run: Run) -> tuple[str, dict[str, str]]:
    """CSV of what the controller computer knows, and the units of its columns."""
    to_motors = constants.motor_map(run.parameters.drive.lead)
    wanted = (run.reference.joints - run.reference.joints[0]) @ to_motors.T
    columns = {"t": (run.reference.time, "s")}
    for i, motor in enumerate(MOTORS):
        columns[f"psi_{motor}_ref"] = (wanted[:, i], "rad")
        columns[f"psi_{motor}"] = (run.measured[:, i], "rad")
        columns[f"tau_{motor}"] = (run.command[:, i], "N m")
    text = io.StringIO()
    np.savetxt(
        text,
        np.column_stack([values for values, _ in columns.values()]),
        delimiter=",",
        header=",".join(columns),
        comments="",
        fmt="%.9g",
    )
    return text.getvalue(), {name: unit for name, (_, unit) in columns.items()}


def log_set(run: Run, config: PMCLoopConfig, units: dict[str, str]) -> str:
    """``logset.yaml`` of one run."""
    content: dict[str, Any] = {
        "format": 1,
        "name": f"pmc-{config.controller}-{config.cycle}",
        "system": {
            "kind": "pmc",
            "nominal": asdict(run.parameters),
            "home": [float(value) for value in run.reference.joints[0]],
        },
        "controller": {"kind": config.controller, **asdict(config.settings())},
        "sample_time_s": config.sample_time,
        "columns": units,
        "runs": [{"file": "run.csv", "motion": config.cycle, "speed": config.speed, "use": "fit"}],
    }
    # Tuples become lists: YAML's safe readers refuse Python tuples.
    return yaml.safe_dump(_lists(content), sort_keys=False)


def pose_errors(run: Run) -> Floats:
    """Errors of the pose (samples, 4) [m, rad]: true minus reference."""
    return kinematics.forward(run.joints, run.parameters.geometry) - run.reference.poses


def _lists(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _lists(item) for key, item in value.items()}
    if isinstance(value, tuple | list):
        return [_lists(item) for item in value]
    return value
