"""``gapscope simulate 5r``: a run of the five-bar's diagram, its log set, its figure, and the numbers of section 4.1.4."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from ...diagrams.five_bar_loop import PORTS, FiveBarLoop, build
from ...models.paths import Circle, Line
from ...models.paths import Path as ToolPath
from ...systems.servo.current_loop import CurrentLoop
from ..errors import InputError
from ..files import write_folder

Array = NDArray[np.float64]

SETTLE = 0.5  # after the path ends [s]
HEIGHT = 0.9  # y of the X move; not printed [m]
CENTRE, ACCELERATION = (0.0, 0.8), 5.0  # of the circles; not printed [m, m/s^2]
PATHS: dict[str, ToolPath] = {
    "x-move": Line(start=(-0.6, HEIGHT), end=(0.6, HEIGHT), feed=1.0, acceleration=1.0),
    "circle": Circle(centre=CENTRE, radius=0.2, turns=2.0, feed=0.628, acceleration=ACCELERATION),
    "fast-circle": Circle(
        centre=CENTRE, radius=0.2, turns=2.0, feed=1.256, acceleration=ACCELERATION
    ),
}
GAINS = {"x-move": 3.54, "circle": 19.2, "fast-circle": 19.2}  # k_v [1/s], printed


@dataclass(frozen=True, kw_only=True)
class FiveBarRun:
    """Signals (samples, 2) of one run, sampled with the velocity loop."""

    loop: FiveBarLoop
    path: ToolPath
    name: str
    t: Array  # (samples,) [s]
    reference: Array  # tool [m]
    joint_reference: Array  # [rad]
    joint_position: Array  # [rad]
    joint_rate: Array  # [rad/s]
    current: Array  # [A]
    position: Array  # tool [m]

    def numbers(self) -> dict[str, float]:
        """Deviations from path and command: largest tool distance to the path, lag, motor turns."""
        moving = self.t <= self.path.profile.duration
        turns = (self.joint_reference - self.joint_position) / self.loop.axis.per_motor
        motor = self.joint_rate / self.loop.axis.per_motor
        return {
            "path_deviation_mm": 1e3 * float(np.max(np.abs(self.off_path()[moving]))),
            "tracking_error_mm": 1e3
            * float(np.max(np.linalg.norm(self.position - self.reference, axis=1))),
            "joint_error_motor_turns": float(np.max(np.abs(turns))) / (2.0 * np.pi),
            "peak_motor_torque_Nm": self.loop.axis.torque_constant
            * float(np.max(np.abs(self.current))),
            "peak_motor_rate_rpm": float(np.max(np.abs(motor))) * 30.0 / np.pi,
        }

    def off_path(self) -> Array:
        """Signed distance (samples,) of the tool from the line, or from the circle's radius [m]."""
        if isinstance(self.path, Circle):
            return np.linalg.norm(self.position - self.path.centre, axis=1) - self.path.radius
        along = np.subtract(self.path.end, self.path.start) / self.path.profile.length
        off = self.position - np.asarray(self.path.start)
        return np.asarray(along[0] * off[:, 1] - along[1] * off[:, 0])


def current_loop(bandwidth: float | None) -> CurrentLoop | None:
    """A current loop of a bandwidth [Hz] on the default windings; InputError where its samples are too slow for it."""
    if bandwidth is None:
        return None
    fastest = 0.2 / CurrentLoop().period
    if not bandwidth <= fastest:
        raise InputError(
            "simulate 5r",
            f"--current-bandwidth is {bandwidth:g} Hz",
            f"at most {fastest:g} Hz, a fifth of the current loop's sample rate",
            "Lower it, or leave it out for motors that carry the current asked for.",
        )
    return CurrentLoop(bandwidth=2.0 * np.pi * bandwidth)


def simulate(
    loop: FiveBarLoop, name: str = "x-move", progress: Callable[[float], None] | None = None
) -> FiveBarRun:
    """Run the diagram on a path of ``PATHS``; InputError where the machine leaves its workspace."""
    from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
    from pydrake.systems.framework import DiagramBuilder, EventStatus
    from pydrake.systems.primitives import VectorLogSink

    path = PATHS[name]
    builder = DiagramBuilder()
    diagram = builder.AddSystem(build(loop, path))
    sinks: dict[str, Any] = {}
    for port in PORTS:
        sinks[port] = builder.AddSystem(VectorLogSink(2, publish_period=loop.velocity_period))
        builder.Connect(diagram.GetOutputPort(port), sinks[port].get_input_port())
    simulator = Simulator(builder.Build())
    ResetIntegratorFromFlags(simulator, "runge_kutta2", loop.step)
    end = path.profile.duration + SETTLE

    def watch(root: Any) -> EventStatus:
        if progress is not None:
            progress(root.get_time())
        own = diagram.GetMyContextFromRoot(root)
        rate: Any = diagram.GetOutputPort("joint_rate").Eval(own)
        if np.all(np.abs(rate) < 1e3):
            return EventStatus.DidNothing()
        return EventStatus.ReachedTermination(diagram, "diverged")

    simulator.set_monitor(watch)
    with np.errstate(all="ignore"):
        simulator.AdvanceTo(end)
    context = simulator.get_context()
    if context.get_time() < end - 1e-9:
        raise InputError(
            "simulate 5r",
            f"the loop diverged {context.get_time():.3f} s after its start",
            "gains and a machine that the axes can hold",
            "Lower the gain. As a disturbance, the machine must be lighter than the axes: see --coupling plant.",
        )
    logs = {port: sink.FindLog(context) for port, sink in sinks.items()}
    signals = {port: np.ascontiguousarray(log.data().T) for port, log in logs.items()}
    t = logs["reference"].sample_times().copy()
    return FiveBarRun(loop=loop, path=path, name=name, t=t, **signals)


def write(run: FiveBarRun, out: Path) -> list[Path]:
    """``logset.yaml``, ``run1.csv`` and ``run1.png``; all are finished before the first is put in place."""
    from .five_bar_plot import plot

    names = ("q1_ref", "q2_ref", "q1", "q2", "current1", "current2")
    columns = np.column_stack([run.t, run.joint_reference, run.joint_position, run.current])
    return write_folder(
        out,
        {
            "run1.csv": lambda path: np.savetxt(
                path,
                columns,
                delimiter=",",
                comments="",
                header=",".join(("t", *names)),
                fmt="%.12g",
            ),
            "run1.png": lambda path: plot(run, path),
            "logset.yaml": lambda path: path.write_text(
                yaml.safe_dump(logset_document(run), sort_keys=False), encoding="utf-8"
            ),
        },
    )


def logset_document(run: FiveBarRun) -> dict[str, Any]:
    """``logset.yaml``; the nominal model is the machine as simulated."""
    axis, geometry = run.loop.axis, run.loop.machine.geometry
    return {
        "format": 1,
        "name": f"five_bar-{run.loop.scheme}-{run.name}",
        "source": "gapscope simulate 5r, a Drake diagram",
        "system": {
            "kind": "five_bar",
            "nominal": {
                "base_m": geometry.base,
                "crank1_m": geometry.crank1,
                "rod2_m": geometry.rod2,
                "rod3_m": geometry.rod3,
                "crank4_m": geometry.crank4,
                "tool_m": geometry.tool,
                **{f"mass{i}_kg": m for i, m in enumerate(geometry.masses, start=1)},
                "gear_ratio": 1.0 / axis.per_motor,
                "torque_constant_Nm_per_A": axis.torque_constant,
                "rotor_inertia_kg_m2": axis.inertia,
                "viscous_Nms_per_rad": axis.viscous,
                "coulomb_Nm": axis.coulomb,
                "sign_width_rad_per_s": 1.0 / axis.sign_rate,
            },
        },
        "controllers": {str(run.loop.scheme): {"kind": str(run.loop.scheme)}},
        "sample_time_s": run.loop.velocity_period,
        "columns": {
            "t": "s", "q1_ref": "rad", "q2_ref": "rad", "q1": "rad", "q2": "rad",
            "current1": "A", "current2": "A",
        },
        "runs": [
            {"file": "run1.csv", "controller": str(run.loop.scheme), "motion": run.name, "use": "fit"}
        ],
    }  # fmt: skip
