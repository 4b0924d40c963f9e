"""Parameter sets in lanes: the loops of one drive, several sets at a time."""

import numpy as np
import pytest

from gapscope.models import c_drive, drive, drive_batch, drive_kernels
from gapscope.models.c_drive_controllers import PD, loop_controller
from gapscope.models.lanes import LANES

DT, SAMPLES, SETS = 1e-3, 150, LANES + 3
# Sums in another order and tanh and exp of four last places, grown by the loop over 150 samples.
TOLERANCE = 1e-11


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


def single_loop(task, plant, lsb):
    reference, acceleration, controller = task
    position, command, delivered = (np.zeros((SAMPLES, 2)) for _ in range(3))
    position[0] = 0.1
    memory = drive_kernels.initial_memory(controller, position[0])
    drive_kernels.simulate(
        reference, acceleration, plant, controller, DT, 2, lsb, memory, position, command, delivered
    )
    return position, command


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
