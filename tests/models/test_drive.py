"""The coupling between two shafts: a spring without clearance, a contact that only pushes with one."""

import numpy as np
import pytest

from gapscope.models import drive
from gapscope.models.drive import coupling_force

STIFFNESS, DAMPING, GAP = 2000.0, 0.2, 0.02


def test_a_coupling_without_clearance_pulls_and_pushes():
    assert coupling_force(-1e-4, 3.0, STIFFNESS, DAMPING, 0.0) == pytest.approx(-0.2 + 0.6)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_clearance_pushes_in_contact_and_never_pulls(side):
    assert coupling_force(side * 0.0099, side * 5.0, STIFFNESS, DAMPING, GAP) == 0.0
    pressed = coupling_force(side * 0.0101, side * 0.1, STIFFNESS, DAMPING, GAP)
    assert pressed == pytest.approx(side * (0.2 + 0.02))
    assert coupling_force(side * 0.0101, side * -5.0, STIFFNESS, DAMPING, GAP) == 0.0


@pytest.mark.parametrize(
    ("column", "loading"), [(drive.LOAD_FRICTION, 3.0), (drive.NET_LOAD_FRICTION, 1.0)]
)
def test_friction_grows_with_the_drive_torque_or_with_what_the_bias_leaves_of_it(column, loading):
    plant = drive.ideal_drive(np.eye(1), np.eye(1), np.zeros(1), 1e-3)
    plant.shaft[0, column], plant.shaft[0, drive.BIAS] = 0.2, 2.0
    net, held = np.zeros(1), np.zeros(1)
    for speed in (-5.0, 5.0):  # far beyond the width of the sign
        drive.net_torque(np.zeros(1), np.array([speed]), held, np.array([3.0]), 0.0, plant, net)
        assert net[0] == pytest.approx(3.0 - 2.0 - np.sign(speed) * 0.2 * loading)
