"""Pictures of machines: rods are rigid, sliders move them, diagrams are drawn."""

import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from pydrake.systems.framework import DiagramBuilder
from pydrake.systems.primitives import Gain
from typer.testing import CliRunner

from gapscope.analysis.cli import app
from gapscope.analysis.errors import InputError
from gapscope.analysis.view import replay, scene
from gapscope.analysis.view.block_diagram import svg
from gapscope.analysis.view.diagrams import DIAGRAMS, diagram
from gapscope.analysis.view.skeletons import MACHINES, skeleton


@pytest.mark.parametrize("name", MACHINES)
def test_rods_keep_their_length_and_parts_are_complete(name):
    machine = skeleton(name)
    rng = np.random.default_rng(5)
    low, high = (np.array([getattr(c, k) for c in machine.coordinates]) for k in ("low", "high"))
    first = machine.place(machine.start)
    assert set(first) == {*machine.rods, *machine.balls}
    assert np.all((low <= machine.start) & (machine.start <= high))
    reached = 0
    for _ in range(100):
        placed = machine.place(rng.uniform(low, high))
        if not all(np.isfinite(part).all() for part in placed.values()):
            continue
        reached += 1
        for rod in machine.rods:
            length = np.linalg.norm(placed[rod][1] - placed[rod][0])
            assert length == pytest.approx(np.linalg.norm(first[rod][1] - first[rod][0]), abs=1e-12)
    assert reached > 10


def test_closed_loops_of_the_five_bar_and_the_carrier_meet():
    five = skeleton("5r")
    placed = five.place(five.start + np.array([0.2, -0.1]))
    np.testing.assert_allclose(placed["rod 2"][1], placed["rod 3"][1], atol=1e-12)
    carrier = skeleton("pmc")
    placed = carrier.place(carrier.start)
    for limb in "12":
        np.testing.assert_allclose(placed[f"distal {limb}"][1], placed[f"wrist {limb}"], atol=1e-12)
        np.testing.assert_allclose(
            placed[f"proximal {limb}"][1], placed[f"distal {limb}"][0], atol=1e-12
        )
    # The wrists are on the PepperMill's axis.
    np.testing.assert_allclose(placed["wrist 1"][:2], placed["wrist 2"][:2], atol=1e-12)


class Hand:
    """A Meshcat whose sliders are moved and whose stop button is pressed."""

    def __init__(self, meshcat, moves):
        self._meshcat, self._moves = meshcat, iter(moves)

    def __getattr__(self, name):
        return getattr(self._meshcat, name)

    def GetButtonClicks(self, name):
        move = next(self._moves, None)
        if move is None:
            return 1
        self._meshcat.SetSliderValue(*move)
        return 0


def test_sliders_move_the_machine_and_out_of_reach_it_waits():
    meshcat = scene.open_meshcat()
    hand = Hand(
        meshcat, [("crank q1 [rad]", 2.2), ("crank q1 [rad]", 2.2), ("crank q4 [rad]", 0.4)]
    )
    addresses = []
    moves = scene.slide(skeleton("5r"), addresses.append, meshcat=hand, pause=0.0)
    assert addresses[0].startswith("http://localhost:")
    assert moves == 2
    carrier = skeleton("pmc")
    drawing = scene.Drawing(meshcat, carrier, "carrier", scene.STEEL)
    assert drawing.move(carrier.start)
    assert not drawing.move(carrier.start + np.array([0.0, 2.0, 0.0, 0.0]))  # 2 m away


def test_a_page_stands_alone():
    page = scene.still_page(skeleton("c-drive"))
    assert page.lstrip().lower().startswith("<!doctype html")
    assert 'src="http' not in page


class Sizes:
    """A scene that notes the radius of every part."""

    def __init__(self):
        self.radius = {}

    def SetObject(self, path, shape, colour):
        self.radius[path] = shape.radius()

    def SetTransform(self, *_):
        pass


def test_copies_in_one_place_differ_in_thickness():
    found, carrier = Sizes(), skeleton("pmc")
    for name, swell in zip(("measured", "nominal", "diagnosed"), replay.SWELL):
        scene.Drawing(found, carrier, name, scene.STEEL, swell)
    for part, radius in carrier.rods.items() | carrier.balls.items():
        widths = [found.radius[f"{name}/{part}"] for name in ("measured", "diagnosed", "nominal")]
        assert widths[0] == radius
        assert widths[1] > 1.1 * widths[0]
        assert widths[2] > 1.1 * widths[1]


@pytest.mark.parametrize(
    ("factor", "words"),
    [(1.0, "just"), (9.374, "9.37 times"), (12345.6, "12\N{NO-BREAK SPACE}300 times")],
)
def test_factor_of_differences_is_written_in_full(factor, words):
    assert replay._times(factor) == words


def test_unknown_machine_is_one_message():
    with pytest.raises(InputError, match="one of c-drive, slider, pmc"):
        skeleton("toaster")


def test_block_diagram_of_any_diagram():
    pytest.importorskip(
        "pygraphviz", reason="pygraphviz is not installed: pip install 'gapscope[view]'"
    )
    builder = DiagramBuilder()
    first, second = (builder.AddNamedSystem(name, Gain(2.0, 1)) for name in ("first", "second"))
    builder.Connect(first.get_output_port(), second.get_input_port())
    builder.ExportInput(first.get_input_port(), "asked")
    builder.ExportOutput(second.get_output_port(), "given")
    chain = builder.Build()
    chain.set_name("chain")
    drawn = svg(chain)
    root = ElementTree.fromstring(drawn)
    words = {text for element in root.iter() for text in [(element.text or "").strip()] if text}
    assert {"first", "second", "asked", "given"} <= words
    edges = [e for e in root.iter() if e.get("class") == "edge"]
    assert len(edges) == 3
    assert root.get("aria-label") == "Block diagram of chain"
    assert svg(chain) == drawn
    with pytest.raises(ValueError, match="depth is -1"):
        svg(chain, depth=-1)


def test_every_diagram_of_the_toolbox_is_built_and_drawn():
    pytest.importorskip(
        "pygraphviz", reason="pygraphviz is not installed: pip install 'gapscope[view]'"
    )
    for name in DIAGRAMS:
        root = ElementTree.fromstring(svg(diagram(name)))
        assert len([e for e in root.iter() if e.get("class") == "edge"]) > 3, name


OWN = """
from pydrake.systems.primitives import Gain
from neighbour import gain

def build():
    return Gain(gain, 1)

def number():
    return 3

def broken():
    raise ValueError("no robot today")

def misspelt():
    return Gain.twice
"""


def test_a_diagram_of_the_users_own_file(tmp_path):
    (tmp_path / "neighbour.py").write_text("gain = 2.0\n")
    file = tmp_path / "robot.py"
    file.write_text(OWN)
    assert diagram(f"{file}:build").get_output_port().size() == 1
    for function, message in (
        ("number", "returns a int"),
        ("broken", "no robot today"),
        ("misspelt", "misspelt: .*twice"),
        ("nothing", "no function 'nothing'"),
    ):
        with pytest.raises(InputError, match=message):
            diagram(f"{file}:{function}")
    with pytest.raises(InputError, match="no such file"):
        diagram("elsewhere.py:build")
    with pytest.raises(InputError, match="one of c-drive, c-drive-ts"):
        diagram("toaster")


@pytest.mark.parametrize(
    ("what", "suffix", "holds"),
    [(("slider",), ".html", "<html"), (("stick-slip", "--blocks"), ".svg", "<svg")],
)
def test_a_name_without_a_suffix_gets_the_one_of_its_content(tmp_path, what, suffix, holds):
    given = (["view", *what, "--out", str(tmp_path / name)] for name in ("a", "b.page"))
    for arguments, name in zip(given, (f"a{suffix}", "b.page"), strict=True):
        done = CliRunner().invoke(app, arguments)
        assert done.exit_code == 0, done.output + str(done.exception)
        assert done.output.strip() == str(tmp_path / name)
        assert holds in (tmp_path / name).read_text()[:2000]
    assert len(list(tmp_path.iterdir())) == 2
