"""Parameter sets in lanes: the loops of one drive, several sets at a time."""

import numpy as np
import pytest

from gapscope.models import c_drive, drive, drive_batch, drive_kernels
from gapscope.models.c_drive_controllers import PD, feedback, loop_controller
from gapscope.models.lanes import LANES

DT, SAMPLES, SETS = 1e-3, 150, LANES + 3
# Sums in another order and tanh and exp of four last places, grown by the loop over 150 samples.
TOLERANCE = 1e-11
# Each impact in a clearance multiplies what the motions differ by before it.
IMPACTS = 1e-9


def plants(rng):
    """Every effect that is no clearance, of other strength in each set; some sets have no Stribeck peak."""
    nominal = c_drive.drive(c_drive.CDriveParameters(delta=0.1, eta=0.05))
    sets = drive_batch.repeated(nominal, SETS)
    sets.inertia_inverse[:] *= rng.uniform(0.7, 1.3, (SETS, 1, 1))

    def put(array, column, low, high):
        array[:, :, column] = rng.uniform(low, high, array.shape[:2])

    for column, *spread in (
        (drive.VISCOUS, 2e-3, 6e-3), (drive.VISCOUS_SKEW, 0.0, 1e-3), (drive.FORWARD, 0.05, 0.1),
        (drive.BACKWARD, 0.05, 0.1), (drive.BREAKAWAY, 0.0, 0.04), (drive.STRIBECK_SPEED, 1.0, 3.0),
        (drive.FADE, 0.0, 2.0),
    ):  # fmt: skip
        put(sets.element, column, *spread)
    sets.element[:5, :, drive.BREAKAWAY] = 0.0
    for column, *spread in (
        (drive.LOAD_FRICTION, 0.0, 0.05), (drive.NET_LOAD_FRICTION, 0.0, 0.05), (drive.BIAS, -0.1, 0.1), (drive.RIPPLE_COS, 0.0, 0.05),
        (drive.RIPPLE_SIN, 0.0, 0.05), (drive.RIPPLE_WAVENUMBER, 1.0, 4.0), (drive.GAIN, 0.9, 1.1),
        (drive.LIMIT, 0.5, 3.0), (drive.LAG, 1e-3, 2e-3), (drive.DELAY, 1.2e-3, 1.8e-3),
    ):  # fmt: skip
        put(sets.shaft, column, *spread)
    sets.shaft[:, :, drive.STAGES] = 2.0
    return sets


def one(sets, i):
    own = [name for name in drive.Drive._fields if name != "elements"]
    return sets._replace(**{name: np.ascontiguousarray(getattr(sets, name)[i]) for name in own})


@pytest.fixture(scope="module")
def task():
    t = DT * np.arange(SAMPLES)[:, None]
    reference = np.array([2.0, -3.0]) * np.sin(30.0 * t) ** 2 + 0.1
    acceleration = 1800.0 * np.array([2.0, -3.0]) * np.cos(60.0 * t)
    return reference, acceleration, loop_controller(PD(), c_drive.CDriveParameters(), DT)


@pytest.fixture(scope="module", params=["tanh", "bristles"])
def sets(request):
    found = plants(np.random.default_rng(11))
    if request.param == "bristles":
        found.element[:, :, drive.STIFFNESS] = 40.0
    return found


def single_loop(task, plant, lsb, substeps=2, first_sensed=0):
    reference, acceleration, controller = task
    position, command, delivered = (np.zeros(reference.shape) for _ in range(3))
    position[0] = 0.1
    memory = drive_kernels.initial_memory(controller, position[0])
    drive_kernels.simulate(
        reference, acceleration, plant, controller, DT, substeps, lsb, memory, position, command,
        delivered, first_sensed,
    )  # fmt: skip
    return position, command


def flexible(rng):
    """A motor that drives a load through a clearance, with Stribeck decays of other exponents."""
    inertia = np.diag([1e-3, 4e-3])
    sets = drive_batch.repeated(drive.ideal_drive(inertia, np.eye(2), 5e-3, 0.5), SETS)
    element = sets.element
    element[:, :, drive.FORWARD] = rng.uniform(0.05, 0.1, (SETS, 2))
    element[:, :, drive.BACKWARD] = element[:, :, drive.FORWARD]
    element[:, :, drive.BREAKAWAY] = rng.uniform(0.01, 0.04, (SETS, 2))
    element[:, :, drive.STRIBECK_SPEED] = rng.uniform(1.0, 3.0, (SETS, 2))
    element[:, :, drive.STRIBECK_EXPONENT] = rng.uniform(0.7, 1.6, (SETS, 2))
    element[::4, :, drive.STRIBECK_EXPONENT] = 2.0
    joined = np.zeros((SETS, 1, drive.COUPLING_COLUMNS))
    joined[:, :, drive.TO_SHAFT] = 1.0
    joined[:, 0, drive.COUPLING_STIFFNESS] = rng.uniform(30.0, 60.0, SETS)
    joined[:, 0, drive.COUPLING_DAMPING] = rng.uniform(0.01, 0.03, SETS)
    joined[:, 0, drive.GAP] = rng.uniform(0.01, 0.03, SETS)
    return sets._replace(coupling=joined)


def test_flexible_drives_in_lanes_are_those_of_the_loop_of_one():
    """A coupling with clearance, the encoder on the load, Stribeck decays of exponents from 0.7 to 2."""
    sets = flexible(np.random.default_rng(5))
    reference = np.sin(30.0 * DT * np.arange(SAMPLES))[:, None] ** 2 + 0.1
    one_by_one = np.eye(1)
    controller = feedback(
        kp=2.0 * one_by_one, ki=0.0 * one_by_one, kd=0.05 * one_by_one, cutoff=600.0,
        output=one_by_one,
    )  # fmt: skip
    task = reference, np.zeros_like(reference), controller
    found = drive_batch.simulate(
        *task[:2], sets, controller, DT, 2, 0.0, np.array([0.1]), first_sensed=1
    )
    logs = [single_loop(task, one(sets, i), 0.0, first_sensed=1) for i in range(SETS)]
    for i, (position, _) in enumerate(logs):
        wanted = np.sqrt(np.mean((reference - position) ** 2, axis=0))
        np.testing.assert_allclose(found.error_rms[i], wanted, rtol=IMPACTS)
    ahead = drive_batch.predict(*logs[0], sets, DT, 2, 60.0, first_sensed=1)
    residual = np.empty((SAMPLES, 1))
    for i in range(SETS):
        drive_kernels.predict(*logs[0], one(sets, i), DT, 2, 60.0, residual, 1)
        np.testing.assert_allclose(ahead[i], residual, rtol=0.0, atol=IMPACTS)


def test_each_set_is_tracked_as_by_the_loop_of_one(sets, task):
    reference, acceleration, controller = task
    start = np.array([0.1, 0.1])
    found = drive_batch.simulate(reference, acceleration, sets, controller, DT, 2, 0.0, start)
    for i in range(SETS):
        position, command = single_loop(task, one(sets, i), 0.0)
        error = reference - position
        expected = (
            np.sqrt(np.mean(error**2, axis=0)), np.max(np.abs(error), axis=0),
            np.sqrt(np.mean(command**2, axis=0)), np.max(np.abs(command), axis=0),
        )  # fmt: skip
        for name, values, wanted in zip(found._fields, found, expected):
            np.testing.assert_allclose(values[i], wanted, rtol=TOLERANCE, err_msg=f"{name} {i}")


def test_each_set_is_predicted_as_by_the_loop_of_one(sets, task):
    position, command = single_loop(task, one(sets, 0), 1e-3)
    found = drive_batch.predict(position, command, sets, DT, 2, 60.0, threads=1)
    assert found.shape == (SETS, SAMPLES, 2)
    residual = np.empty((SAMPLES, 2))
    for i in range(SETS):
        drive_kernels.predict(position, command, one(sets, i), DT, 2, 60.0, residual)
        np.testing.assert_allclose(found[i], residual, rtol=0.0, atol=TOLERANCE)


@pytest.mark.parametrize(
    ("field", "column", "value", "words"),
    [
        ("element", drive.STIFFNESS, 40.0, "presliding stiffness"),
        ("shaft", drive.DELAY, 2.5e-3, "whole samples of delay"),
        ("shaft", drive.LAG, 0.0, "lag, zero or not"),
        ("shaft", drive.STAGES, 1.0, "stages of the lag"),
    ],
)
def test_sets_that_differ_in_structure_are_refused(field, column, value, words, task):
    mixed = plants(np.random.default_rng(12))
    getattr(mixed, field)[3, 0, column] = value
    with pytest.raises(ValueError, match=words):
        drive_batch.predict(task[0], task[0], mixed, DT, 1, 60.0)


def test_drives_are_put_side_by_side():
    drives = [c_drive.drive(c_drive.CDriveParameters(beta=b)) for b in (1e-3, 2e-3)]
    both = drive_batch.stacked(drives)
    assert both.element[:, 0, drive.VISCOUS].tolist() == [1e-3, 2e-3]
    assert one(both, 1).inertia_inverse.tolist() == drives[1].inertia_inverse.tolist()
    with pytest.raises(ValueError, match="no drive"):
        drive_batch.stacked([])
    drives[0].elements[0, 0] = -1.0
    with pytest.raises(ValueError, match="`elements`"):
        drive_batch.stacked(drives)


@pytest.mark.parametrize("field", ["element", "shaft"])
def test_no_effect_is_left_out_where_it_acts_alone(field, task):
    """The kernel of one drive leaves out what a drive has not; that of many never does."""
    position, command = single_loop(task, c_drive.drive(c_drive.CDriveParameters()), 0.0)
    plain = c_drive.drive(c_drive.CDriveParameters())
    columns = {
        "element": (drive.VISCOUS_SKEW, drive.FADE),
        "shaft": (drive.LOAD_FRICTION, drive.NET_LOAD_FRICTION, drive.RIPPLE_COS, drive.RIPPLE_SIN, drive.DELAY, drive.LAG),
    }[field]  # fmt: skip
    without = np.empty((SAMPLES, 2))
    drive_kernels.predict(position, command, plain, DT, 2, 60.0, without)
    for column in columns:
        plant = plain.copy()
        getattr(plant, field)[:, column] = 2e-3
        residual = np.empty((SAMPLES, 2))
        drive_kernels.predict(position, command, plant, DT, 2, 60.0, residual)
        assert np.max(np.abs(residual - without)) > 1e-9, column
        sets = drive_batch.stacked([plant])
        (found,) = drive_batch.predict(position, command, sets, DT, 2, 60.0, threads=1)
        np.testing.assert_allclose(found, residual, rtol=0.0, atol=TOLERANCE)
