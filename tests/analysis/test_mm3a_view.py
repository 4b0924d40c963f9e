"""The square drawn open-loop, and its replay page."""

import numpy as np
import pytest

from gapscope.analysis.mm3a import square
from gapscope.diagrams.mm3a_view import replay_page

HALF_STEP_AT_TIP = 0.5 * (0.050 * 122e-6 + 0.044 * 122e-6 + 1.35e-6)


def test_square_closes_within_half_a_step_by_the_step_model_only():
    drawing = square.draw_square()
    misses = {
        name: np.linalg.norm(drawing.tips(name)[1:] - drawing.wanted, axis=1).max()
        for name in drawing.joints
    }
    assert misses["step model"] < HALF_STEP_AT_TIP
    assert misses["constant step"] > 2.0 * HALF_STEP_AT_TIP


def test_replay_page_stands_alone():
    joints = np.array([[0.3, -1.2, 0.006], [0.3001, -1.2, 0.006]])
    page = replay_page(joints)
    assert page.lstrip().lower().startswith("<!doctype html")
    assert len(page) > 100_000  # the viewer is inside
    with pytest.raises(ValueError, match="expected \\(n, 3\\)"):
        replay_page(joints[0])
