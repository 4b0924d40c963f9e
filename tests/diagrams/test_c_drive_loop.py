"""The C-drive's loop on Drake against the compiled batch loop, and its settings."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import VectorLogSink

from gapscope.diagrams import c_drive_config as config_
from gapscope.diagrams.c_drive_config import Amplifier, CDriveLoopConfig, Machine
from gapscope.diagrams.c_drive_controller import c_drive_controller
from gapscope.diagrams.c_drive_loop import actuated_drive, c_drive_loop
from gapscope.models import drive_kernels, encoder
from gapscope.models.c_drive import CDriveParameters
from gapscope.models.c_drive_controllers import loop_controller
from gapscope.models.motion import C_DRIVE_MOTIONS

# The same laws in another order of sums: rounding grows through the loop to 2e-12, DESIGN.md asks
# for 1e-11.
AGREEMENT = 1e-11


def run(config, *ports, samples=600):
    """Samples (n, 2) of the named ports of the loop's Diagram."""
    builder = DiagramBuilder()
    loop = builder.AddSystem(c_drive_loop(config))
    sinks = []
    for port in ports:
        sinks.append(builder.AddSystem(VectorLogSink(2, publish_period=config.sample_time)))
        builder.Connect(loop.GetOutputPort(port), sinks[-1].get_input_port())
    simulator = Simulator(builder.Build())
    simulator.get_mutable_integrator().set_target_accuracy(1e-9)
    simulator.AdvanceTo(config.sample_time * (samples - 1))
    return [sink.FindLog(simulator.get_context()).data().T for sink in sinks]


def batch(config, samples=600):
    """The same signals from ``drive_kernels.simulate``."""
    dt = config.sample_time
    reference, _, acceleration = config.program().sample(dt * np.arange(samples))
    controller = loop_controller(config.controller.settings(), config.believed(), dt)
    position, command, torque = (np.zeros((samples, 2)) for _ in range(3))
    drive_kernels.simulate(
        reference,
        acceleration,
        actuated_drive(config),
        controller,
        dt,
        1,
        encoder.resolution(config.encoder_bits) if config.encoder_bits else 0.0,
        drive_kernels.initial_memory(controller, np.zeros(2)),
        position,
        command,
        torque,
    )
    return reference, position, command, torque


def agree(config):
    got = run(config, "reference", "measured", "command", "torque")
    for ours, theirs in zip(got, batch(config)):
        scale = np.abs(theirs).max()
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=AGREEMENT * scale)


@pytest.mark.parametrize("motion", sorted(C_DRIVE_MOTIONS))
@pytest.mark.parametrize("controller", ["pd", "ts", "ct"])
def test_loop_repeats_the_batch_loop(controller, motion):
    agree(
        CDriveLoopConfig(
            controller=config_.CONTROLLERS[controller](), motion=motion, model_error=1.05
        )
    )


@pytest.mark.parametrize(
    "settings",
    [
        {"controller": config_.PD(ki=200.0)},
        {"controller": config_.ResolvedAcceleration(kp_translation=50e3, kp_rotation=30e3)},
        {"machine": Machine(delta=0.12, eta=0.05)},
        {"amplifier": Amplifier(gain=0.95, limit=1.5, lag=6e-4, delay=1.3e-3)},
        {"encoder_bits": 0},
        {"controller": config_.ComputedTorque(), "machine": Machine(delta=0.2), "rate": 1.0},
    ],
    ids=["PID", "resolved acceleration", "Coulomb", "amplifier", "exact encoder", "1 Hz"],
)
def test_loop_repeats_the_batch_loop_with(settings):
    agree(CDriveLoopConfig(**settings))


def test_continuous_plant_gives_the_same_loop():
    """Without an encoder, whose counts would make a difference of rounding visible at random."""
    config = CDriveLoopConfig(controller=config_.ComputedTorque(), encoder_bits=0)
    (sampled,) = run(config, "position")
    config.plant = "continuous"
    (continuous,) = run(config, "position")
    # ODE4 at 1 ms on decay rates below 10/s is exact to 1e-10, the integrator to its accuracy.
    np.testing.assert_allclose(continuous, sampled, rtol=0, atol=1e-8 * np.abs(sampled).max())


def test_loop_exports_the_ports_of_its_docstring():
    loop = c_drive_loop(CDriveLoopConfig(controller=config_.ComputedTorque()))
    names = [loop.get_output_port(i).get_name() for i in range(loop.num_output_ports())]
    assert names == [
        "reference",
        "reference_velocity",
        "reference_acceleration",
        "measured",
        "position",
        "velocity",
        "command",
        "torque",
    ]
    for name in ("source", "controller", "amplifier", "plant", "encoder"):
        assert loop.GetSubsystemByName(name).get_name() == name


@pytest.mark.parametrize(
    ("name", "inputs"),
    [
        ("pd", ["reference", "position"]),
        ("ts", ["reference", "position"]),
        ("ct", ["reference", "position", "acceleration"]),
        ("ra", ["reference", "position", "acceleration"]),
    ],
)
def test_controllers_have_the_ports_of_their_docstring(name, inputs):
    settings = config_.CONTROLLERS[name]().settings()
    controller = c_drive_controller(settings, CDriveParameters(), 1e-3)
    got = [controller.get_input_port(i).get_name() for i in range(controller.num_input_ports())]
    assert got == inputs
    assert controller.GetOutputPort("torque").size() == 2


def test_equal_gains_make_task_space_and_resolved_acceleration_joint_space_controllers():
    """Eq. (4.38), on whole runs."""
    pairs = [
        (config_.PD(), config_.TaskSpacePD(kp_rotation=45.0, kd_rotation=0.1)),
        (config_.ComputedTorque(), config_.ResolvedAcceleration()),
    ]
    for joint, task in pairs:
        a, b = (
            run(CDriveLoopConfig(controller=c), "command", samples=300)[0] for c in (joint, task)
        )
        np.testing.assert_allclose(a, b, rtol=0, atol=AGREEMENT * np.abs(a).max())


def test_one_diagram_serves_two_contexts_with_different_constants():
    loop = c_drive_loop(CDriveLoopConfig())
    plant = loop.GetSubsystemByName("plant")
    ends = []
    for factor in (1.0, 2.0, 1.0):
        context = loop.CreateDefaultContext()
        own = plant.GetMyMutableContextFromRoot(context)
        element = own.get_mutable_numeric_parameter(plant.ELEMENT)
        element.SetAtIndex(0, factor * element[0])
        Simulator(loop, context).AdvanceTo(0.1)
        ends.append(loop.GetOutputPort("position").Eval(context).copy())
    np.testing.assert_array_equal(ends[0], ends[2])
    assert np.abs(ends[0] - ends[1]).max() > 1e-4


def test_example_file_is_the_thesis_run():
    config = config_.parse_config(config_.example_config())
    assert config.controller == config_.ComputedTorque()
    assert (config.model_error, config.cycles, config.amplifier.limit) == (1.05, 4, None)
    c_drive_loop(config)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("motoin: helical", "unknown key .motoin.; expected .*motion"),
        ("machine: {betta: 1.0}", "betta"),
        ("controller: !PDD {kp: 1.0}", "PDD"),
        ("controller: !PD {kq: 1.0}", "kq"),
        ("rate: fast", "rate|fast"),
        ("cycles: [1]", "cycles"),
        ("machine: 3", "found 3 where keys"),
        ("- 1\n- 2", "list"),
        ("rate: [", "YAML"),
    ],
)
def test_unusable_settings_end_in_one_error(text, words, tmp_path):
    (tmp_path / "loop.yaml").write_text(text)
    with pytest.raises(ValueError, match=words) as error:
        config_.load_config(tmp_path / "loop.yaml")
    assert "loop.yaml" in str(error.value)


@pytest.mark.parametrize(
    ("settings", "word"),
    [
        ({"motion": "spiral"}, "spiral"),
        ({"rate": 0.0}, "rate"),
        ({"rate": 80.0}, "rate"),
        ({"cycles": 0}, "cycles"),
        ({"sample_time": -1e-3}, "sample_time"),
        ({"encoder_bits": -1}, "encoder_bits"),
        ({"model_error": 0.0}, "model_error"),
        ({"plant": "analog"}, "plant"),
        ({"machine": Machine(beta=-1.0)}, "beta"),
        ({"amplifier": Amplifier(lag=-1.0)}, "lag"),
        ({"amplifier": Amplifier(limit=0.0)}, "limit"),
        ({"controller": config_.PD(cutoff=0.0)}, "cutoff"),
        ({"controller": config_.ComputedTorque(observer_pole=1.0)}, "pole"),
    ],
)
def test_impossible_settings_are_named(settings, word):
    with pytest.raises(ValueError, match=word):
        c_drive_loop(CDriveLoopConfig(**settings))
