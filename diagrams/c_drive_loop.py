"""The C-drive's control loop as a Diagram: source, controller, amplifier, plant and encoder."""

from typing import Any

import numpy as np
from pydrake.systems.framework import Diagram, DiagramBuilder, System
from pydrake.systems.primitives import ZeroOrderHold

from ..models import c_drive, encoder
from ..models.drive import DELAY, GAIN, LAG, LIMIT, Drive
from ..models.fourier_motion import FourierMotion
from ..systems.drive_plant import DrivePlant
from ..systems.encoder import Encoder
from ..systems.fourier_source import FourierSource
from ..systems.motion_source import MotionSource
from ..systems.sampled_drive_plant import SampledDrivePlant
from ..systems.torque_amplifier import TorqueAmplifier
from .c_drive_config import CDriveLoopConfig
from .c_drive_controller import c_drive_controller


def c_drive_loop(config: CDriveLoopConfig) -> Diagram:
    """Wire one C-drive loop; nothing is simulated yet.

    | port | size | unit |
    |---|---|---|
    | out `reference`              | 2 | rad, motors (L, R) |
    | out `reference_velocity`     | 2 | rad/s |
    | out `reference_acceleration` | 2 | rad/s^2 |
    | out `measured`               | 2 | rad, what the encoders read |
    | out `position`               | 2 | rad, of the motors |
    | out `velocity`               | 2 | rad/s |
    | out `command`                | 2 | N m, of the controller |
    | out `torque`                 | 2 | N m, at the motors, mean over a sample |

    The subsystems ``source``, ``controller``, ``amplifier``, ``plant`` and ``encoder`` are found by name
    (``GetSubsystemByName``); their constants are numeric parameters of the Context. With the sampled
    plant and time steps of one sample the loop repeats ``drive_kernels.simulate``. Raises ValueError,
    naming the key, for settings no loop can be built with.
    """
    config.check()
    dt = config.sample_time
    drive = actuated_drive(config)
    lsb = encoder.resolution(config.encoder_bits) if config.encoder_bits else 0.0
    builder = DiagramBuilder()
    program = config.program()
    kind = FourierSource if isinstance(program, FourierMotion) else MotionSource
    source = _add(builder, "source", kind(program))
    controller = _add(
        builder,
        "controller",
        c_drive_controller(config.controller.settings(), config.believed(), dt),
    )
    amplifier = _add(builder, "amplifier", TorqueAmplifier(drive, dt))
    encoders = _add(builder, "encoder", Encoder(2, lsb))
    torque = amplifier.GetOutputPort("torque")
    if config.plant == "sampled":
        plant = _add(builder, "plant", SampledDrivePlant(drive, dt))
        builder.Connect(torque, plant.GetInputPort("torque"))
    else:
        plant = _add(builder, "plant", DrivePlant(drive))
        hold = _add(builder, "hold", ZeroOrderHold(dt, 2))
        builder.Connect(torque, hold.get_input_port())
        builder.Connect(hold.get_output_port(), plant.GetInputPort("torque"))
    builder.Connect(plant.GetOutputPort("position"), encoders.GetInputPort("angle"))
    builder.Connect(encoders.GetOutputPort("position"), controller.GetInputPort("position"))
    builder.Connect(source.GetOutputPort("position"), controller.GetInputPort("reference"))
    if controller.HasInputPort("acceleration"):
        builder.Connect(
            source.GetOutputPort("acceleration"), controller.GetInputPort("acceleration")
        )
    builder.Connect(controller.GetOutputPort("torque"), amplifier.GetInputPort("command"))
    for name, port in (
        ("reference", source.GetOutputPort("position")),
        ("reference_velocity", source.GetOutputPort("velocity")),
        ("reference_acceleration", source.GetOutputPort("acceleration")),
        ("measured", encoders.GetOutputPort("position")),
        ("position", plant.GetOutputPort("position")),
        ("velocity", plant.GetOutputPort("velocity")),
        ("command", controller.GetOutputPort("torque")),
        ("torque", torque),
    ):
        builder.ExportOutput(port, name)
    diagram = builder.Build()
    diagram.set_name("c_drive_loop")
    return diagram


def actuated_drive(config: CDriveLoopConfig) -> Drive:
    """The drive of the config with its amplifier's constants in the columns of ``Drive.shaft``."""
    drive = c_drive.drive(config.machine.parameters())
    amplifier = config.amplifier
    drive.shaft[:, DELAY] = amplifier.delay
    drive.shaft[:, GAIN] = amplifier.gain
    drive.shaft[:, LIMIT] = np.inf if amplifier.limit is None else amplifier.limit
    drive.shaft[:, LAG] = amplifier.lag
    return drive


def _add(builder: DiagramBuilder, name: str, system: System) -> Any:
    system.set_name(name)
    return builder.AddSystem(system)
