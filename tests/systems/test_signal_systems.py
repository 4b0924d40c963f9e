"""Encoder, delay, derivative, amplifier, motion source and error: the small systems of a loop."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import VectorLogSink
from scipy.linalg import expm
from scipy.signal import cont2discrete, lfilter

from gapscope.models import drive, encoder, motion
from gapscope.systems.encoder import Encoder
from gapscope.systems.filtered_derivative import FilteredDerivative
from gapscope.systems.motion_source import MotionSource
from gapscope.systems.torque_amplifier import TorqueAmplifier
from gapscope.systems.tracking_error import TrackingError
from gapscope.systems.unit_delay import UnitDelay

DT = 1e-3


def driven(system, in_port, out_port, samples=50, source_port="acceleration"):
    """Samples (n, 2) of ``system`` driven by a motion: its input and its output."""
    builder = DiagramBuilder()
    source = builder.AddSystem(MotionSource(motion.c_drive_motion("helical", 10.0)))
    builder.AddSystem(system)
    builder.Connect(source.GetOutputPort(source_port), system.GetInputPort(in_port))
    sinks = [builder.AddSystem(VectorLogSink(2, publish_period=DT)) for _ in range(2)]
    builder.Connect(source.GetOutputPort(source_port), sinks[0].get_input_port())
    builder.Connect(system.GetOutputPort(out_port), sinks[1].get_input_port())
    simulator = Simulator(builder.Build())
    simulator.AdvanceTo(DT * (samples - 1))
    before, after = (sink.FindLog(simulator.get_context()).data().T for sink in sinks)
    return before, after


def test_motion_source_is_the_batch_reference_at_the_same_times():
    before, _ = driven(UnitDelay(2, DT), "signal", "delayed")
    wanted = motion.c_drive_motion("helical", 10.0).sample(DT * np.arange(50))[2]
    np.testing.assert_array_equal(before, wanted)


def test_unit_delay_shifts_by_one_sample_and_starts_at_zero():
    before, after = driven(UnitDelay(2, DT), "signal", "delayed")
    np.testing.assert_array_equal(after[1:], before[:-1])
    np.testing.assert_array_equal(after[0], 0.0)


def test_filtered_derivative_is_the_transfer_function_for_held_inputs():
    """Against scipy's zero-order-hold discretisation of N s / (N + s)."""
    before, after = driven(FilteredDerivative(2, 600.0, DT), "signal", "derivative")
    b, a, _ = cont2discrete(([600.0, 0.0], [1.0, 600.0]), DT, method="zoh")
    wanted = lfilter(b[0], a, before, axis=0)
    np.testing.assert_allclose(after, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


def test_encoder_reads_the_nearest_count():
    lsb = encoder.resolution(13)
    before, after = driven(Encoder(2, lsb), "angle", "position", source_port="position")
    counts = after / lsb
    np.testing.assert_allclose(counts, np.rint(counts), atol=1e-9)
    assert np.abs(after - before).max() <= 0.5 * lsb * (1 + 1e-12)
    exact = driven(Encoder(2, 0.0), "angle", "position", source_port="position")
    np.testing.assert_array_equal(*exact)


def amplifier(**columns):
    plant = drive.ideal_drive(np.eye(2), np.eye(2), [0.0, 0.0], 1.0)
    for name, value in columns.items():
        plant.shaft[:, getattr(drive, name)] = value
    return TorqueAmplifier(plant, DT)


def test_ideal_amplifier_delivers_its_command():
    before, after = driven(amplifier(), "command", "torque")
    np.testing.assert_array_equal(after, before)


def test_amplifier_saturates_after_its_gain():
    before, after = driven(amplifier(GAIN=1e-3, LIMIT=2.0), "command", "torque")
    np.testing.assert_allclose(after, np.clip(1e-3 * before, -2.0, 2.0), rtol=1e-15)
    assert np.any(after == 2.0)


@pytest.mark.parametrize("delay", [0.0, 1.0, 2.0, 0.4, 1.7])
def test_amplifier_delays_by_whole_and_part_samples(delay):
    before, after = driven(amplifier(DELAY=delay * DT), "command", "torque")
    whole, part = int(delay), delay - int(delay)
    padded = np.vstack([np.tile(before[:1], (3, 1)), before])
    newer, older = padded[3 - whole : 53 - whole], padded[2 - whole : 52 - whole]
    wanted = (1.0 - part) * newer + part * older
    np.testing.assert_allclose(after, wanted, rtol=0, atol=1e-12 * np.abs(wanted).max())


def test_lagging_amplifier_delivers_the_mean_of_the_exact_response():
    """Mean torque over a sample from a fine integration of T tau' + tau = u."""
    lag, fine = 2e-3, 2000
    before, after = driven(amplifier(LAG=lag), "command", "torque", samples=20)
    decay, torque = np.exp(-DT / fine / lag), np.zeros(2)
    for command, got in zip(before, after):
        total = np.zeros(2)
        for _ in range(fine):
            following = command + (torque - command) * decay
            total += 0.5 * (torque + following)
            torque = following
        error = (DT / fine / lag) ** 2 / 12.0 * np.abs(before).max()
        np.testing.assert_allclose(got, total / fine, rtol=0, atol=2 * error + 1e-9)


def test_two_stages_deliver_the_mean_of_the_exact_response():
    """Mean torque over a sample from the matrix exponential of both stages and their integral."""
    lag = 3e-3
    before, after = driven(amplifier(LAG=lag, STAGES=2), "command", "torque", samples=20)
    rate = 2.0 / lag
    system = np.array([[-rate, 0, 0, rate], [rate, -rate, 0, 0], [0, 1, 0, 0], [0, 0, 0, 0]])
    step, state = expm(DT * system), np.zeros((4, 2))
    for command, got in zip(before, after):
        state[2], state[3] = 0.0, command
        state = step @ state
        np.testing.assert_allclose(got, state[2] / DT, rtol=0, atol=1e-12 * np.abs(before).max())


def test_tracking_error_is_reference_minus_position():
    system = TrackingError(2)
    context = system.CreateDefaultContext()
    system.GetInputPort("reference").FixValue(context, [3.0, 1.0])
    system.GetInputPort("position").FixValue(context, [1.0, 5.0])
    np.testing.assert_array_equal(system.GetOutputPort("error").Eval(context), [2.0, -4.0])


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: Encoder(2, -1.0), "lsb"),
        (lambda: UnitDelay(2, 0.0), "period"),
        (lambda: FilteredDerivative(2, -600.0, DT), "cutoff"),
        (lambda: FilteredDerivative(2, 600.0, float("nan")), "period"),
        (lambda: amplifier(DELAY=-DT), "delays"),
    ],
)
def test_impossible_settings_are_refused_by_name(make, word):
    with pytest.raises(ValueError, match=word):
        make()
