"""The C-drive's control loop as a Diagram made for speed: samples of the reference, linear controller, encoded drive."""

from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import LinearSystem, Multiplexer, TrajectorySource
from pydrake.trajectories import PiecewisePolynomial

from ..models import encoder
from ..models.c_drive_controllers import loop_controller
from ..models.linear_controller import linear_controller
from ..systems.encoded_drive import EncodedDrive
from .c_drive_config import CDriveLoopConfig
from .c_drive_loop import actuated_drive

ACCELERATION = slice(2, 4)  # columns of the controller's inputs


def c_drive_sampled_loop(config: CDriveLoopConfig, duration: float) -> Diagram:
    """Wire one C-drive loop of which only the drive calls back into Python, once a sample.

    | port | size | unit |
    |---|---|---|
    | out `reference` | 2 | rad, motors (L, R) |
    | out `measured`  | 2 | rad, what the encoders read |
    | out `command`   | 2 | N m, of the controller |
    | out `state`     | 11 | rad, rad/s: see ``EncodedDrive`` |

    The numbers are those of ``c_drive_loop`` at every sample, to rounding. ``source`` holds the reference's samples
    for ``duration`` seconds and the last one from then on, ``controller`` is a ``LinearSystem`` of the matrices
    of ``linear_controller``, ``drive`` an ``EncodedDrive``. For gains and constants that are parameters of the
    Context, a late actuator or a continuous plant use ``c_drive_loop``. Raises ValueError, naming the key, for settings
    no such loop can be built with.
    """
    config.check()
    _check(config, duration)
    dt = config.sample_time
    law = linear_controller(
        loop_controller(config.controller.settings(), config.believed(), dt), dt
    )
    lsb = encoder.resolution(config.encoder_bits) if config.encoder_bits else 0.0
    builder = DiagramBuilder()
    reference, acceleration = _samples(config, duration)
    source = _add(builder, "source", _held(reference, dt))
    drive = _add(builder, "drive", EncodedDrive(actuated_drive(config), dt, lsb))
    inputs = [source.get_output_port(), drive.GetOutputPort("measured")]
    if np.any(law.d[:, ACCELERATION]):
        inputs.insert(1, _add(builder, "acceleration", _held(acceleration, dt)).get_output_port())
    else:
        law = law._replace(b=np.delete(law.b, ACCELERATION, 1), d=np.delete(law.d, ACCELERATION, 1))
    controller = _add(builder, "controller", LinearSystem(*law, time_period=dt))
    signals = _add(builder, "signals", Multiplexer([2] * len(inputs)))
    for i, port in enumerate(inputs):
        builder.Connect(port, signals.get_input_port(i))
    builder.Connect(signals.get_output_port(), controller.get_input_port())
    builder.Connect(controller.get_output_port(), drive.get_input_port())
    builder.ExportOutput(source.get_output_port(), "reference")
    builder.ExportOutput(drive.GetOutputPort("measured"), "measured")
    builder.ExportOutput(controller.get_output_port(), "command")
    builder.ExportOutput(drive.GetOutputPort("state"), "state")
    diagram = builder.Build()
    diagram.set_name("c_drive_sampled_loop")
    return diagram


def _check(config: CDriveLoopConfig, duration: float) -> None:
    if not 0.0 < duration < np.inf:
        raise ValueError(f"duration is {duration}; expected a positive number [s]")
    if config.plant != "sampled":
        raise ValueError(f"plant is {config.plant!r}; expected 'sampled'. Use c_drive_loop")
    if config.amplifier.delay != 0.0:
        raise ValueError(
            f"amplifier.delay is {config.amplifier.delay} s; expected 0. Use c_drive_loop"
        )


def _samples(config: CDriveLoopConfig, duration: float) -> tuple[Any, Any]:
    """Reference [rad] and its acceleration [rad/s^2], (samples, 2)."""
    samples = int(np.ceil(duration / config.sample_time)) + 1
    reference, _, acceleration = config.program().sample(config.sample_time * np.arange(samples))
    return reference, acceleration


def _held(samples: Any, dt: float) -> TrajectorySource:
    """Samples held from half a sample before: a clock early by a rounding finds its own."""
    breaks = dt * (np.arange(len(samples) + 1) - 0.5)
    values = np.vstack([samples, samples[-1:]]).T
    return TrajectorySource(PiecewisePolynomial.ZeroOrderHold(breaks, values))


def _add(builder: DiagramBuilder, name: str, system: System) -> Any:
    system.set_name(name)
    return builder.AddSystem(system)
