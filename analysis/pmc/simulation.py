"""``gapscope simulate pmc``: run the Diagram, write its log as a log set, a figure and a 3-D replay."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...diagrams.pmc_loop import PMCLoopConfig, pmc_loop
from ...models.pmc import kinematics
from ...models.pmc.simulation import Run, sample_cycle
from ..errors import InputError
from ..files import output_folder, write_whole

Floats = NDArray[np.float64]


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
    """Run and write ``logset.yaml``, ``run.csv``, ``run.png`` and ``replay.html`` into ``out``."""
    from ...diagrams.pmc_view import replay_html
    from . import logs, run_plot

    folder = output_folder(out)
    try:
        run = run_diagram(config, cycles, progress)
    except InputError:
        raise
    except ValueError as error:
        raise InputError(
            "simulate pmc", str(error), "settings that a loop can be built with"
        ) from error
    logged = logs.LoggedRun(
        file="run.csv",
        use="fit",
        config=config,
        reference=run.reference,
        measured=run.measured,
        command=run.command,
    )
    name = f"pmc-{config.controller}-{config.cycle}"
    logs.write(folder, name, [logged], run.parameters, run.reference.joints[0])
    write_whole(folder / "run.png", run_plot.png(run, config))
    if replay:
        page = replay_html(
            run.reference.time, run.joints, run.parameters, reference=run.reference.poses
        )
        write_whole(folder / "replay.html", page)
    return run


def pose_errors(run: Run) -> Floats:
    """Errors of the pose (samples, 4) [m, rad]: true minus reference."""
    return kinematics.forward(run.joints, run.parameters.geometry) - run.reference.poses
