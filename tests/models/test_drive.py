"""The coupling between two shafts: a spring without clearance, a contact that only pushes with one."""

import pytest

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
