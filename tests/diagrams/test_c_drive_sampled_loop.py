"""The fast Diagram of the C-drive's loop against the compiled batch loop, and what it refuses."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import ConstantVectorSource, VectorLogSink

from gapscope.diagrams import c_drive_config as config_
from gapscope.diagrams.c_drive_config import Amplifier, CDriveLoopConfig, Machine
from gapscope.diagrams.c_drive_loop import actuated_drive
from gapscope.diagrams.c_drive_sampled_loop import c_drive_sampled_loop
from gapscope.models import drive, drive_kernels, encoder
from gapscope.models.c_drive_controllers import loop_controller
from gapscope.models.linear_controller import linear_controller
from gapscope.systems.encoded_drive import EncodedDrive
from gapscope.systems.encoder import Encoder
from gapscope.systems.sampled_drive_plant import SampledDrivePlant
from gapscope.systems.torque_amplifier import TorqueAmplifier

SAMPLES = 600
# The same laws in another order of sums, as for the loop of blocks.
AGREEMENT = 1e-11


def run(config):
    builder = DiagramBuilder()
    loop = builder.AddSystem(c_drive_sampled_loop(config, config.sample_time * SAMPLES))
    sinks = []
    for port in ("measured", "command"):
        sinks.append(builder.AddSystem(VectorLogSink(2, publish_period=config.sample_time)))
        builder.Connect(loop.GetOutputPort(port), sinks[-1].get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(config.sample_time * (SAMPLES - 1))
    return [sink.FindLog(simulator.get_context()).data().T for sink in sinks]


def batch(config):
    dt = config.sample_time
    reference, _, acceleration = config.program().sample(dt * np.arange(SAMPLES))
    controller = loop_controller(config.controller.settings(), config.believed(), dt)
    position, command, torque = (np.zeros((SAMPLES, 2)) for _ in range(3))
    lsb = encoder.resolution(config.encoder_bits) if config.encoder_bits else 0.0
    memory = drive_kernels.initial_memory(controller, np.zeros(2))
    drive_kernels.simulate(
        reference, acceleration, actuated_drive(config), controller, dt, 1, lsb, memory,
        position, command, torque,
    )  # fmt: skip
    return position, command


@pytest.mark.parametrize(
    "settings",
    [
        {"controller": config_.PD(), "machine": Machine(delta=0.12, eta=0.05)},
        {"controller": config_.PD(ki=200.0), "motion": "rotation"},
        {"controller": config_.TaskSpacePD(), "encoder_bits": 0},
        {"controller": config_.ComputedTorque(), "model_error": 1.05},
        {"amplifier": Amplifier(gain=0.95, limit=1.5, lag=6e-4)},
    ],
    ids=["PD and Coulomb", "PID", "task space, exact encoder", "computed torque", "amplifier"],
)
def test_sampled_loop_repeats_the_batch_loop(settings):
    config = CDriveLoopConfig(**settings)
    for ours, theirs in zip(run(config), batch(config)):
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=AGREEMENT * np.abs(theirs).max())


@pytest.mark.parametrize(
    ("config", "duration", "words"),
    [
        (CDriveLoopConfig(amplifier=Amplifier(delay=1e-3)), 1.0, "amplifier.delay is 0.001 s"),
        (CDriveLoopConfig(plant="continuous"), 1.0, "plant is 'continuous'"),
        (CDriveLoopConfig(), 0.0, "duration is 0.0"),
    ],
)
def test_what_the_sampled_loop_cannot_do_is_refused(config, duration, words):
    with pytest.raises(ValueError, match=words):
        c_drive_sampled_loop(config, duration)


def test_encoded_drive_starts_where_it_is_put_and_refuses_delay():
    config = CDriveLoopConfig()
    plant = actuated_drive(config)
    system = EncodedDrive(plant, 1e-3, 0.25)
    context = system.CreateDefaultContext()
    system.set_position(context, [0.6, -1.0])
    assert system.GetOutputPort("measured").Eval(context).tolist() == [0.5, -1.0]
    assert system.GetOutputPort("state").Eval(context)[:4].tolist() == [0.6, -1.0, 0.0, 0.0]
    plant.shaft[:, drive.DELAY] = 1e-3
    with pytest.raises(ValueError, match="delays are"):
        EncodedDrive(plant, 1e-3, 0.25)


def test_encoded_drive_is_the_three_blocks_in_a_row_while_friction_fades():
    dt, lsb = 1e-3, 1e-4
    plant = actuated_drive(CDriveLoopConfig(amplifier=Amplifier(lag=4e-4)))
    plant.element[:, drive.FADE] = 30.0
    builder = DiagramBuilder()
    command = builder.AddSystem(ConstantVectorSource([0.4, -0.1]))
    blocks = [TorqueAmplifier(plant, dt), SampledDrivePlant(plant, dt), Encoder(2, lsb)]
    ends = []
    for row in ([EncodedDrive(plant, dt, lsb)], blocks):
        port = command.get_output_port()
        for system in row:
            builder.AddSystem(system)
            builder.Connect(port, system.get_input_port(0))
            port = system.get_output_port(0)
        ends.append(builder.AddSystem(VectorLogSink(2, publish_period=dt)))
        builder.Connect(port, ends[-1].get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(0.1)
    fast, slow = (end.FindLog(simulator.get_context()).data() for end in ends)
    assert np.ptp(slow) > 100 * lsb
    np.testing.assert_allclose(fast, slow, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("change", "words"), [({"kind": 1}, "a cascade"), ({"limit": 2.0}, "limits its command to 2")]
)
def test_controllers_that_are_not_linear_are_refused(change, words):
    config = CDriveLoopConfig()
    controller = loop_controller(config.controller.settings(), config.believed(), 1e-3)
    with pytest.raises(ValueError, match=words):
        linear_controller(controller._replace(**change), 1e-3)
