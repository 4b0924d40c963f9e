"""``gapscope simulate 5r | 2prr | replalink | mast | 3prs``: a run of a servo diagram, its log set, figure and numbers."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from ...diagrams.servo_loop import PORTS, ServoLoop, build
from ...models.paths import Circle, Line
from ...models.paths import Path as ToolPath
from ...systems.servo.current_loop import CurrentLoop
from ..errors import InputError
from ..files import write_folder
from .servo_machines import ServoMachine, axis_nominal

Array = NDArray[np.float64]

SETTLE = 0.5  # after the path ends [s]
RUNAWAY = 1e3  # rate of a joint at which a run counts as diverged [rad/s or m/s]


@dataclass(frozen=True, kw_only=True)
class ServoRun:
    """Signals (samples, n) of one run, sampled with the velocity loop."""

    loop: ServoLoop
    path: ToolPath
    name: str  # of the motion
    t: Array  # (samples,) [s]
    reference: Array  # task coordinates [m or rad]
    joint_reference: Array  # [rad or m]
    joint_position: Array  # [rad or m]
    joint_rate: Array  # per s
    current: Array  # [A]
    position: Array  # task coordinates [m or rad]

    def numbers(self) -> dict[str, float]:
        """Deviations from path and command, in mm and mrad, and what the motors do."""
        turns = (self.joint_reference - self.joint_position) / self.loop.axis.per_motor
        motor = self.joint_rate / self.loop.axis.per_motor
        return {
            **self._deviations(),
            "joint_error_motor_turns": float(np.max(np.abs(turns))) / (2.0 * np.pi),
            "peak_motor_torque_Nm": self.loop.axis.torque_constant
            * float(np.max(np.abs(self.current))),
            "peak_motor_rate_rpm": float(np.max(np.abs(motor))) * 30.0 / np.pi,
        }

    @property
    def planar(self) -> bool:
        """Whether the path is a curve of the plane, from which a distance can be told."""
        return isinstance(self.path, Line | Circle)

    def off_path(self) -> Array:
        """Signed distance (samples,) of the tool from the line, or from the circle's radius [m]."""
        if isinstance(self.path, Circle):
            return np.linalg.norm(self.position - self.path.centre, axis=1) - self.path.radius
        assert isinstance(self.path, Line)
        along = np.subtract(self.path.end, self.path.start) / self.path.profile.length
        off = self.position - np.asarray(self.path.start)
        return np.asarray(along[0] * off[:, 1] - along[1] * off[:, 0])

    def _deviations(self) -> dict[str, float]:
        error = 1e3 * np.abs(self.position - self.reference)
        if self.planar:
            moving = self.t <= self.path.duration
            return {
                "path_deviation_mm": 1e3 * float(np.max(np.abs(self.off_path()[moving]))),
                "tracking_error_mm": float(np.max(np.linalg.norm(error, axis=1))),
            }
        return {
            f"{name}_error_{milli(name)}": float(worst)
            for name, worst in zip(self.loop.machine.task, error.max(axis=0))
        }


def milli(coordinate: str) -> str:
    """Unit of a thousandth of a task coordinate."""
    return "mm" if coordinate in ("x", "y", "z") else "mrad"


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
    loop: ServoLoop,
    path: ToolPath,
    name: str,
    *,
    seconds: float | None = None,
    progress: Callable[[float], None] | None = None,
) -> ServoRun:
    """Run the diagram until it has settled, or for some seconds; InputError where it diverges or leaves its workspace."""
    from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator
    from pydrake.systems.framework import DiagramBuilder, EventStatus
    from pydrake.systems.primitives import VectorLogSink

    builder, size = DiagramBuilder(), len(loop.machine.joints)
    diagram = builder.AddSystem(build(loop, path))
    sinks: dict[str, Any] = {}
    for port in PORTS:
        sinks[port] = builder.AddSystem(VectorLogSink(size, publish_period=loop.velocity_period))
        builder.Connect(diagram.GetOutputPort(port), sinks[port].get_input_port())
    simulator = Simulator(builder.Build())
    ResetIntegratorFromFlags(simulator, "runge_kutta2", loop.step)
    end = path.duration + SETTLE if seconds is None else seconds

    def watch(root: Any) -> EventStatus:
        if progress is not None:
            progress(root.get_time() / end)
        own = diagram.GetMyContextFromRoot(root)
        rate: Any = diagram.GetOutputPort("joint_rate").Eval(own)
        if np.all(np.abs(rate) < RUNAWAY):
            return EventStatus.DidNothing()
        return EventStatus.ReachedTermination(diagram, "diverged")

    simulator.set_monitor(watch)
    with np.errstate(all="ignore"):
        simulator.AdvanceTo(end)
    context = simulator.get_context()
    if context.get_time() < end - 1e-9:
        raise _diverged(loop, context.get_time())
    logs = {port: sink.FindLog(context) for port, sink in sinks.items()}
    signals = {port: np.ascontiguousarray(log.data().T) for port, log in logs.items()}
    t = logs["reference"].sample_times().copy()
    return ServoRun(loop=loop, path=path, name=name, t=t, **signals)


def _diverged(loop: ServoLoop, time: float) -> InputError:
    return InputError(
        "simulate",
        f"the loop diverged {time:.3f} s after its start",
        "gains that hold, and with --coupling disturbance a machine lighter than its axes",
        "Lower the gain."
        if loop.coupling == "plant"
        else "Take --coupling plant, or lower the gain.",
    )


def write(machine: ServoMachine, run: ServoRun, out: Path) -> list[Path]:
    """``run1.csv``, ``run1.png`` and ``logset.yaml``; all finished before any is in place."""
    from .servo_plot import plot

    numbers = range(1, len(run.loop.machine.joints) + 1)
    names = [f"{word.format(i)}" for word in ("q{}_ref", "q{}", "current{}") for i in numbers]
    columns = np.column_stack([run.t, run.joint_reference, run.joint_position, run.current])
    header = ",".join(("t", *names))
    document = yaml.safe_dump(logset_document(machine, run), sort_keys=False)
    files: dict[str, Callable[[Path], Any]] = {
        "run1.csv": lambda path: np.savetxt(
            path, columns, delimiter=",", comments="", header=header, fmt="%.12g"
        ),
        "run1.png": lambda path: plot(machine, run, path),
        "logset.yaml": lambda path: path.write_text(document, encoding="utf-8"),
    }
    return write_folder(out, files)


def logset_document(machine: ServoMachine, run: ServoRun) -> dict[str, Any]:
    """``logset.yaml``; the nominal model is the machine as simulated."""
    scheme, numbers = str(run.loop.scheme), range(1, len(run.loop.machine.joints) + 1)
    nominal = {
        **machine.nominal(run.loop.machine),
        **axis_nominal(run.loop, machine.joint_unit),
    }
    units = (("q{}_ref", machine.joint_unit), ("q{}", machine.joint_unit), ("current{}", "A"))
    return {
        "format": 1,
        "name": f"{machine.kind}-{scheme}-{run.name}",
        "source": "gapscope simulate, a Drake diagram",
        "system": {"kind": machine.kind, "nominal": {k: float(v) for k, v in nominal.items()}},
        "controllers": {scheme: {"kind": scheme}},
        "sample_time_s": run.loop.velocity_period,
        "columns": {"t": "s", **{w.format(i): unit for w, unit in units for i in numbers}},
        "runs": [{"file": "run1.csv", "controller": scheme, "motion": run.name, "use": "fit"}],
    }
