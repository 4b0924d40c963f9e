"""Servo diagram of any parallel machine, as in Roldan's Figs. 3.12-3.18: path, control, axes, machine.

    path -> inverse kinematics -> loops -> windings -> axes -> forward kinematics
                                   ^                   |  ^ load
                                   +-------------------+  +-> inverse dynamics of the machine

The outer loop closes on the joints or on the platform; computed torque replaces it by the inverse dynamics. The machine
is a disturbance of the axes (Fig. 3.4) or one plant with them. Each machine's settings have a file of their own.
"""

from dataclasses import dataclass
from enum import StrEnum
from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder
from pydrake.systems.primitives import Gain

from ..models.parallel.machine import ParallelMachine
from ..models.paths import Path
from ..models.servo_axis import ServoAxis
from ..systems.servo.axes import CoupledAxes, ServoAxes
from ..systems.servo.computed_torque import ComputedTorqueLoop
from ..systems.servo.current_loop import CurrentLoop
from ..systems.servo.kinematics import ForwardKinematics, InverseKinematics
from ..systems.servo.machine_load import MachineLoad
from ..systems.servo.path_source import PathSource
from ..systems.servo.pi_loop import PILoop
from ..systems.servo.position_loop import PositionLoop


class Scheme(StrEnum):
    """Control schemes of section 3.3."""

    joint = "joint-space"
    workspace = "workspace"
    torque = "computed-torque"
    torque_workspace = "computed-torque-workspace"


class Coupling(StrEnum):
    """How the machine acts on its axes."""

    disturbance = "disturbance"  # Fig. 3.4
    plant = "plant"  # one coupled plant


@dataclass(frozen=True, kw_only=True)
class ServoLoop:
    """Settings of the diagram; a subclass in a file of its own holds those of one machine."""

    machine: ParallelMachine
    axis: ServoAxis
    scheme: Scheme = Scheme.joint
    coupling: Coupling = Coupling.disturbance
    position_gain: float  # k_v [1/s]
    feedforward: float = 0.0  # of the reference's rate [-]
    position_filter: float = 0.0  # time constant [s]
    velocity_filter: float = 0.0  # time constant [s]
    velocity_kp: float  # [A s/rad]
    velocity_ki: float  # times the integral of the speed error [A/rad]
    current_limit: float = np.inf  # [A]
    current_loop: CurrentLoop | None = None  # with the windings; none: the current asked for flows
    torque_kp: float = 2500.0  # of computed torque [1/s^2]; chosen, double pole at 50 rad/s
    torque_kv: float = 100.0  # [1/s]; chosen
    position_period: float  # [s]
    velocity_period: float  # and of computed torque [s]
    step: float  # of the integration and of the machine's load [s]


PORTS = ("reference", "joint_reference", "joint_position", "joint_rate", "current", "position")


def build(loop: ServoLoop, path: Path) -> Diagram:
    """The diagram, at rest at the start of the path, with the output ports ``PORTS``.

    Raises ValueError where the path starts out of reach.
    """
    start = loop.machine.inverse(path.sample(0.0)[0])
    if not np.isfinite(start).all():
        raise ValueError(f"the path starts at {path.sample(0.0)[0]}; expected a point in reach")
    builder = DiagramBuilder()
    source = builder.AddNamedSystem("path", PathSource(path))
    inverse = builder.AddNamedSystem("inverse_kinematics", InverseKinematics(loop.machine))
    forward = builder.AddNamedSystem("forward_kinematics", ForwardKinematics(loop.machine))
    _connect(builder, source, inverse, ("position", "velocity", "acceleration"))
    axes = _axes(builder, loop, start)
    current = _control(builder, loop, source, inverse, axes)
    if loop.current_loop is not None:
        current = loop.current_loop.connect(builder, current, axes, loop.axis.per_motor)
    builder.Connect(current, axes.GetInputPort("current"))
    builder.Connect(axes.GetOutputPort("position"), forward.GetInputPort("joint_position"))
    for name, port in zip(PORTS, (
        source.GetOutputPort("position"), inverse.GetOutputPort("joint_position"),
        axes.GetOutputPort("position"), axes.GetOutputPort("rate"),
        current, forward.GetOutputPort("position"),
    )):  # fmt: skip
        builder.ExportOutput(port, name)
    return builder.Build()


def _axes(builder: Any, loop: ServoLoop, start: Any) -> Any:
    if loop.coupling == Coupling.plant:
        return builder.AddNamedSystem("axes", CoupledAxes(loop.axis, loop.machine, start))
    axes = builder.AddNamedSystem("axes", ServoAxes(loop.axis, start))
    load = builder.AddNamedSystem("inverse_dynamics", MachineLoad(loop.machine, loop.step))
    _connect(builder, axes, load, ("position", "rate", "acceleration"))
    builder.Connect(load.GetOutputPort("load"), axes.GetInputPort("load"))
    return axes


def _control(builder: Any, loop: ServoLoop, source: Any, inverse: Any, axes: Any) -> Any:
    """The controller's systems, connected; their port of currents."""
    names = ("position", "velocity", "acceleration")
    if not (task := loop.scheme in (Scheme.workspace, Scheme.torque_workspace)):
        names, source = ("joint_position", "joint_rate", "joint_acceleration"), inverse
    if loop.scheme in (Scheme.torque, Scheme.torque_workspace):
        controller: Any = builder.AddNamedSystem("computed_torque", ComputedTorqueLoop(
            loop.machine, loop.axis, period=loop.velocity_period,
            kp=loop.torque_kp, kv=loop.torque_kv, workspace=task,
        ))  # fmt: skip
        builder.Connect(axes.GetOutputPort("rate"), controller.GetInputPort("joint_rate"))
        current = controller.GetOutputPort("current")
    else:
        size = len(loop.machine.joints)
        controller = builder.AddNamedSystem("position_loop", PositionLoop(
            size, period=loop.position_period, gain=loop.position_gain,
            per_motor=loop.axis.per_motor, feedforward=loop.feedforward,
            filter_time=loop.position_filter, machine=loop.machine if task else None,
        ))  # fmt: skip
        velocity = builder.AddNamedSystem("velocity_loop", PILoop(
            size, period=loop.velocity_period, kp=loop.velocity_kp, ki=loop.velocity_ki,
            limit=loop.current_limit, filter_time=loop.velocity_filter,
        ))  # fmt: skip
        gear = builder.AddNamedSystem("gear", Gain(1.0 / loop.axis.per_motor, size))
        builder.Connect(axes.GetOutputPort("rate"), gear.get_input_port())
        builder.Connect(gear.get_output_port(), velocity.GetInputPort("measured"))
        builder.Connect(controller.GetOutputPort("motor_rate"), velocity.GetInputPort("command"))
        current = velocity.GetOutputPort("output")
    for port, name in zip(("reference", "reference_rate", "reference_acceleration"), names):
        if controller.HasInputPort(port):
            builder.Connect(source.GetOutputPort(name), controller.GetInputPort(port))
    builder.Connect(axes.GetOutputPort("position"), controller.GetInputPort("joint_position"))
    return current


def _connect(builder: Any, source: Any, target: Any, names: tuple[str, ...]) -> None:
    for name in names:
        builder.Connect(source.GetOutputPort(name), target.GetInputPort(name))
