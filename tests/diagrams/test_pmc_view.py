"""The 3-D replay of the PepperMill-Carrier in a real browser."""

import shutil
import subprocess

import numpy as np
import pytest
from matplotlib.image import imread

from gapscope.diagrams.pmc_loop import PMCLoopConfig
from gapscope.diagrams.pmc_view import replay_html
from gapscope.models.pmc import simulation

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
LINK_COLOURS = {"limb 1": (0.0, 0.45, 0.70), "limb 2": (0.84, 0.37, 0.0)}


@pytest.mark.slow
@pytest.mark.skipif(CHROMIUM is None, reason="needs chromium on the path")
def test_replay_shows_both_limbs_in_a_browser(tmp_path):
    """Headless Chromium with software GL draws the page from its file alone."""
    config = PMCLoopConfig(cycle="smooth")
    machine = config.machine()
    reference = simulation.sample_cycle(config.motion(machine), machine, cycles=0.5)
    page, picture = tmp_path / "replay.html", tmp_path / "replay.png"
    page.write_text(
        replay_html(reference.time, reference.joints, machine, reference=reference.poses)
    )
    subprocess.run(
        [
            CHROMIUM,
            "--headless",
            "--no-sandbox",
            "--use-angle=swiftshader",
            "--enable-unsafe-swiftshader",
            "--window-size=900,700",
            "--virtual-time-budget=8000",
            f"--screenshot={picture}",
            page.as_uri(),
        ],
        check=True,
        capture_output=True,
        timeout=120,
    )
    pixels = imread(picture)[..., :3].reshape(-1, 3)
    shades = pixels / (np.linalg.norm(pixels, axis=1, keepdims=True) + 1e-9)
    for colour in LINK_COLOURS.values():
        direction = np.array(colour) / np.linalg.norm(colour)
        assert (shades @ direction > 0.97).sum() > 200
