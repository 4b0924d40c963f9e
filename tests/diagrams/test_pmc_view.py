"""The PepperMill-Carrier in three dimensions, in a real browser: replay in a file, and Meshcat live."""

import shutil
import subprocess

import numpy as np
import pytest
from matplotlib.image import imread
from pydrake.geometry import Meshcat, MeshcatParams

from gapscope.analysis.view import scene
from gapscope.analysis.view.skeletons import skeleton
from gapscope.diagrams.pmc_loop import PMCLoopConfig
from gapscope.diagrams.pmc_view import publish, replay_html
from gapscope.models.pmc import simulation

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser")
LINK_COLOURS = {"limb 1": (0.0, 0.45, 0.70), "limb 2": (0.84, 0.37, 0.0)}

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(CHROMIUM is None, reason="needs chromium on the path"),
]


@pytest.fixture(scope="module")
def motion():
    """Half a smooth cycle and the robot that makes it."""
    config = PMCLoopConfig(cycle="smooth")
    machine = config.machine()
    return simulation.sample_cycle(config.motion(machine), machine, cycles=0.5), machine


def photograph(address, picture):
    """Headless Chromium with software GL: pixels (n, 3) of the page as it stands after eight seconds."""
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
            address,
        ],
        check=True,
        capture_output=True,
        timeout=120,
    )
    return imread(picture)[..., :3].reshape(-1, 3)


def shows(pixels, colour):
    """Whether more than 200 pixels have this colour in some light."""
    shades = pixels / (np.linalg.norm(pixels, axis=1, keepdims=True) + 1e-9)
    direction = np.array(colour) / np.linalg.norm(colour)
    return (shades @ direction > 0.97).sum() > 200


def test_replay_shows_both_limbs_from_its_file_alone(motion, tmp_path):
    reference, machine = motion
    page = tmp_path / "replay.html"
    page.write_text(
        replay_html(reference.time, reference.joints, machine, reference=reference.poses)
    )
    pixels = photograph(page.as_uri(), tmp_path / "replay.png")
    for colour in LINK_COLOURS.values():
        assert shows(pixels, colour)


def test_meshcat_shows_both_limbs_live(motion, tmp_path):
    reference, machine = motion
    meshcat = Meshcat(MeshcatParams(host="localhost"))
    publish(meshcat, reference.time, reference.joints, machine, reference.poses)
    assert meshcat.web_url().startswith("http://localhost:")
    pixels = photograph(meshcat.web_url(), tmp_path / "live.png")
    for colour in LINK_COLOURS.values():
        assert shows(pixels, colour)


def test_view_moves_the_robot_under_an_open_browser(tmp_path):
    """What ``gapscope view pmc`` draws, before and after a drive has turned."""
    carrier = skeleton("pmc")
    meshcat = scene.open_meshcat()
    drawing = scene.Drawing(meshcat, carrier, "carrier", scene.STEEL)
    scene.look(meshcat, carrier)
    pictures = []
    for change in (0.0, 0.4):
        assert drawing.move(carrier.start + change * (np.arange(len(carrier.start)) == 2))
        pictures.append(photograph(meshcat.web_url(), tmp_path / f"view{change}.png"))
    moved = np.abs(pictures[1] - pictures[0]).max(axis=1) > 0.1
    assert 200 < moved.sum() < 0.5 * len(moved)
