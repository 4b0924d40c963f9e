"""Run a C-drive loop on Drake, and write the log as a log set with a figure."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder, EventStatus
from pydrake.systems.primitives import VectorLogSink

from ..diagrams.c_drive_config import (
    PD,
    CDriveLoopConfig,
    ComputedTorque,
    ResolvedAcceleration,
    TaskSpacePD,
)
from ..diagrams.c_drive_loop import c_drive_loop
from ..models.c_drive import collar_pose
from ..models.fourier_motion import FourierMotion
from .errors import InputError
from .files import write_folder

PORTS = ("reference", "measured", "command", "torque", "position")
# The error that means divergence, as a multiple of the motion's amplitude. A loop that works stays
# below 0.01; a position that leaves the reference by twice its amplitude never returns.
DIVERGED = 2.0


@dataclass(frozen=True, kw_only=True)
class CDriveRun:
    """Sampled signals of one run; arrays (samples, 2) for the motors (L, R)."""

    config: CDriveLoopConfig
    t: NDArray[np.float64]  # [s]
    reference: NDArray[np.float64]  # [rad]
    measured: NDArray[np.float64]  # [rad], by the encoders
    command: NDArray[np.float64]  # [N m]
    torque: NDArray[np.float64]  # [N m], at the motors, mean over a sample
    position: NDArray[np.float64]  # [rad], true

    def collar_errors(self) -> NDArray[np.float64]:
        """Errors (samples, 2) of the collar as the encoders see them: u [m] and theta [rad]."""
        return collar_pose(self.reference - self.measured, self.config.machine.lead)


def simulate_c_drive(
    config: CDriveLoopConfig, progress: Callable[[float], None] | None = None
) -> CDriveRun:
    """Run the loop for all cycles of its motion; ``progress`` is told the time reached [s].

    Raises InputError for settings no loop can be built with, and if the loop diverges.
    """
    try:
        loop = c_drive_loop(config)
    except ValueError as error:
        found, _, expected = str(error).partition("; expected ")
        raise InputError("C-drive loop", found, expected or "settings of a usable loop") from None
    dt = config.sample_time
    program = config.program()
    samples = round(config.cycles / (program.rate * dt))
    builder = DiagramBuilder()
    builder.AddSystem(loop)
    sinks: dict[str, Any] = {}
    for port in PORTS:
        sinks[port] = builder.AddSystem(VectorLogSink(2, publish_period=dt))
        builder.Connect(loop.GetOutputPort(port), sinks[port].get_input_port())
    simulator = Simulator(builder.Build())
    limit = DIVERGED * float(np.max(np.abs(program.sample(dt * np.arange(samples))[0])))

    def watch(root: Any) -> EventStatus:
        own = loop.GetMyContextFromRoot(root)
        reference: Any = loop.GetOutputPort("reference").Eval(own)
        position: Any = loop.GetOutputPort("position").Eval(own)
        if progress is not None:
            progress(root.get_time())
        # Written so that NaN, too, counts as diverged.
        if np.all(np.abs(reference - position) < limit):
            return EventStatus.DidNothing()
        return EventStatus.ReachedTermination(loop, "diverged")

    simulator.set_monitor(watch)
    end = dt * (samples - 1)
    with np.errstate(over="ignore", invalid="ignore"):
        simulator.AdvanceTo(end)
    context = simulator.get_context()
    if context.get_time() < end:
        raise InputError(
            "controller",
            f"the loop diverged {context.get_time():.3f} s after its start",
            "gains that keep the machine within twice the motion's amplitude",
            "Lower kp, raise kd, or shorten delay and lag of the amplifier.",
        )
    logs = {name: sink.FindLog(context) for name, sink in sinks.items()}
    signals = {name: np.ascontiguousarray(log.data().T) for name, log in logs.items()}
    _refuse_torque(config, signals["command"])
    return CDriveRun(config=config, t=logs["reference"].sample_times().copy(), **signals)


def write_c_drive_run(run: CDriveRun, out: Path) -> list[Path]:
    """Write the log set (``logset.yaml``, ``run1.csv``) and ``run1.png`` into the folder ``out``.

    All files are finished before the first is put in place. Raises InputError if ``out`` is a file.
    """
    from .simulation_plot import plot_run

    return write_folder(
        out,
        {
            "run1.csv": lambda path: write_table(run, path),
            "run1.png": lambda path: plot_run(run, path),
            "logset.yaml": lambda path: path.write_text(
                yaml.safe_dump(logset_document(run), sort_keys=False), encoding="utf-8"
            ),
        },
    )


def write_table(run: CDriveRun, path: Path) -> None:
    """The columns of a C-drive log set as comma-separated values."""
    columns = np.column_stack([run.t, run.reference, run.measured, run.command])
    np.savetxt(
        path,
        columns,
        delimiter=",",
        header="t,psi_L_ref,psi_R_ref,psi_L,psi_R,tau_L,tau_R",
        comments="",
        fmt=["%.6f"] + ["%.9f"] * 6,
    )


def logset_document(run: CDriveRun) -> dict[str, Any]:
    """``logset.yaml`` of the run; the nominal model is the drive as the controller believes it."""
    config = run.config
    believed = config.believed()
    bits = config.encoder_bits
    encoder = f"rad, {bits}-bit encoder" if bits else "rad, exact encoder"
    name, controller = _controller_block(config)
    return {
        "format": 1,
        "name": f"c_drive-{name}-{config.program().name}-{config.program().rate:g}Hz",
        "source": "gapscope simulate c-drive, a Drake diagram",
        "system": {
            "kind": "c_drive",
            "nominal": {
                "lead_m_per_rev": believed.lead,
                "m11_kg_m2": believed.m11,
                "m12_kg_m2": believed.m12,
                "beta_N_m_s": believed.beta,
                "gamma_N_m_s": believed.gamma,
                "delta_N_m": believed.delta,
                "eta_N_m": believed.eta,
            },
        },
        "controllers": {name: controller},
        "sample_time_s": config.sample_time,
        "columns": {
            "t": "s",
            "psi_L_ref": "rad",
            "psi_R_ref": "rad",
            "psi_L": encoder,
            "psi_R": encoder,
            "tau_L": "Nm, commanded",
            "tau_R": "Nm, commanded",
        },
        "runs": [
            {
                "file": "run1.csv",
                "controller": name,
                **_motion_keys(config),
                "use": "fit",
            }
        ],
    }


def _motion_keys(config: CDriveLoopConfig) -> dict[str, Any]:
    program = config.program()
    if isinstance(program, FourierMotion):
        return {"period_s": program.period, "note": f"motion file {program.name}"}
    return {"motion": config.motion, "rate_Hz": config.rate}


def _refuse_torque(config: CDriveLoopConfig, command: NDArray[np.float64]) -> None:
    """InputError where a motion file asks the motors for more than ``limits.torque``."""
    peak = float(np.max(np.abs(command)))
    if isinstance(config.program(), FourierMotion) and peak > config.limits.torque * 1.001:
        raise InputError(
            config.motion,
            f"the motion asks for {peak:.3f} N m",
            f"at most limits.torque, {config.limits.torque} N m",
            "Scale its coefficients down, or raise the limit in --config if the motors bear it.",
        )


def _controller_block(config: CDriveLoopConfig) -> tuple[str, dict[str, Any]]:
    c = config.controller
    common = {"derivative_filter_rad_per_s": c.cutoff}
    if isinstance(c, PD):
        integral = {"ki_Nm_per_rad_s": c.ki} if c.ki else {}
        gains = {"kp_Nm_per_rad": c.kp, "kd_Nms_per_rad": c.kd, **integral}
        return "pd", {"kind": "pd", **gains, **common}
    if isinstance(c, TaskSpacePD):
        gains = {
            "kp_trans_Nm_per_rad": c.kp_translation,
            "kp_rot_Nm_per_rad": c.kp_rotation,
            "kd_trans_Nms_per_rad": c.kd_translation,
            "kd_rot_Nms_per_rad": c.kd_rotation,
        }
        return "ts", {"kind": "task_space_pd", **gains, **common}
    observer = {
        "observer_pole_rad_per_s": c.observer_pole,
        "friction_compensation": c.friction_compensation,
    }
    if isinstance(c, ComputedTorque):
        gains = {"kp_per_s2": c.kp, "kd_per_s": c.kd}
        return "ct", {"kind": "computed_torque", **gains, **common, **observer}
    assert isinstance(c, ResolvedAcceleration)
    gains = {
        "kp_per_s2": c.kp_translation,
        "kd_per_s": c.kd_translation,
        "kp_rot_per_s2": c.kp_rotation,
        "kd_rot_per_s": c.kd_rotation,
    }
    return "ra", {"kind": "computed_torque", **gains, **common, **observer}
