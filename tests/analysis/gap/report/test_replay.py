"""The replay of a diagnosis: ghosts where the models are, and a page that stands alone."""

from dataclasses import replace

import numpy as np
import pytest

from gapscope.analysis.errors import InputError
from gapscope.analysis.view.replay import page, replay
from gapscope.models.c_drive import collar_pose


def test_ghosts_are_the_models_magnified(diagnosed):
    found = diagnosed["friction"]
    plain, large = replay(found, magnify=1.0), replay(found, magnify=10.0)
    run = next(r for r in found.runs if r.use == "validate")
    np.testing.assert_allclose(plain.measured, collar_pose(run.position, 0.06))
    for name in ("nominal", "diagnosed"):
        np.testing.assert_allclose(
            large.ghosts[name] - plain.measured,
            10.0 * (plain.ghosts[name] - plain.measured),
            atol=1e-12,
        )
    # The diagnosed model is closer to what was measured, and closer than a count of the encoders apart on average.
    off = {n: np.sqrt(np.mean((v - plain.measured) ** 2, axis=0)) for n, v in plain.ghosts.items()}
    assert np.all(off["diagnosed"] < 0.2 * off["nominal"])


def test_by_default_differences_become_visible(diagnosed):
    found = replay(diagnosed["friction"])
    off = np.abs(found.ghosts["nominal"] - found.measured).max(axis=0)
    assert np.max(off / np.ptp(found.measured, axis=0)) == pytest.approx(0.05)


def test_what_stands_still_in_a_run_does_not_decide_how_much_is_enlarged(diagnosed):
    found = replay(diagnosed["friction"], "translation.csv")
    along = np.abs(found.ghosts["nominal"] - found.measured).max(axis=0)[0]
    assert np.ptp(found.measured[:, 1]) < 0.1
    assert along / np.ptp(found.measured[:, 0]) == pytest.approx(0.05)


def test_page_says_who_is_who_and_what_is_enlarged(diagnosed):
    html = page(replay(diagnosed["friction"], magnify=25.0))
    assert "nominal model" in html
    assert "diagnosed model" in html
    assert "25 times their difference" in html
    assert "<img" not in html.split("role='note'")[1]  # the run's name is hostile


def test_a_held_out_run_at_rest_gives_way_to_one_that_moves(diagnosed):
    d = diagnosed["friction"]
    resting = [replace(r, position=0.0 * r.position) if r.use == "validate" else r for r in d.runs]
    found = replay(replace(d, runs=tuple(resting)))
    assert found.run == "translation.csv"
    assert np.ptp(found.measured[:, 0]) > 0.0


def test_unknown_run_is_one_message(diagnosed):
    with pytest.raises(InputError, match="one of translation"):
        replay(diagnosed["friction"], "spiral")
