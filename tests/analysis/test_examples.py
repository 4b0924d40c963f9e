"""Every example runs, is short, draws its picture, and finds what it hides."""

from pathlib import Path

import numpy as np
import pytest
from matplotlib import image

from gapscope.analysis import examples
from gapscope.analysis.examples import (
    blind,
    calibration,
    controllers,
    own_closed_chain,
    own_effect,
    own_robot,
    workspace,
)
from gapscope.analysis.gap import effects, machines

FOLDER = Path(examples.__file__).parent


@pytest.fixture(autouse=True)
def kinds(monkeypatch):
    """Kinds that an example adds are gone after it."""
    monkeypatch.setattr(machines, "KINDS", dict(machines.KINDS))
    for module in (own_robot, own_effect):
        monkeypatch.setattr(module, "KINDS", machines.KINDS)


def drawn(path):
    picture = image.imread(path)
    return picture[..., :3].std() > 0.02


SCRIPTS = sorted(FOLDER.glob("*.py"))


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.stem)
def test_an_example_is_short(path):
    assert len(path.read_text().splitlines()) < 60


@pytest.mark.parametrize(
    ("module", "effect", "name", "truth"),
    [
        (own_robot, "friction.coulomb", "level", 0.1),
        (own_effect, "cable.stiffness", "stiffness", 0.3),
    ],
)
def test_own_robot_and_own_effect_find_what_is_hidden(module, effect, name, truth, tmp_path):
    found = module.main(tmp_path).to_json()
    assert found["verdict"] == "explained"
    assert [e["id"] for e in found["effects"]] == [effect]
    # The nominal parameters that are free beside it are known to 3 %.
    assert found["effects"][0]["parameters"][name]["value"] == pytest.approx(truth, rel=0.03)
    assert drawn(tmp_path / f"{module.__name__.rpartition('.')[2]}.png")


def test_controllers_compared(tmp_path):
    errors = controllers.main(tmp_path)
    assert set(errors) == {"pd", "ct", "ts"}
    assert all(0.0 < u < 2e-3 for u, _ in errors.values())
    assert drawn(tmp_path / "controllers.png")


def test_workspace_is_fully_turning_in_the_middle_and_nowhere_at_the_top(tmp_path):
    assert 0.0 < workspace.main(tmp_path, -0.1) <= 1.0
    assert workspace.main(tmp_path, 0.6) == 0.0
    assert drawn(tmp_path / "workspace.png")


def test_calibration_runs(tmp_path):
    found = calibration.main(tmp_path)
    assert found.likelihood
    assert drawn(tmp_path / "calibration.png")


def test_blind_check_opens_what_it_sealed(tmp_path, monkeypatch):
    """Few forms only, for speed: here the ceremony is tested, not the instrument."""
    every = effects.forms_for
    monkeypatch.setattr(
        effects, "forms_for", lambda *a: [f for f in every(*a) if f.name == "constant"]
    )
    case, result = blind.main(tmp_path)
    assert (tmp_path / "sealed.sha256").read_text().split()[0] == case.seal
    assert case.answer["answer"]
    assert not any("answer" in line for line in (case.logset / "logset.yaml").read_text().split())
    assert result.verdict.verdict in {"explained", "no_gap", "ambiguous", "unexplained"}
    assert drawn(tmp_path / "blind.png")


@pytest.mark.slow
def test_own_closed_chain_is_identified(tmp_path):
    """A four-bar with parameters up to 20 % off: the identified ones predict another motion near the noise."""
    found = own_closed_chain.main(tmp_path)
    assert len(found.base.kept) == len(found.by_qr.kept) == 10
    planted = found.base.combination @ found.truth
    assert (np.abs(found.fitted.values - planted) <= 2.0 * found.fitted.half_width).all()
    assert found.errors["feasible"] < 2.0 * found.errors["planted"]
    assert found.errors["feasible"] < 0.1 * found.errors["theoretical, no friction"]
    for name in ("excitation.png", "parameters.png", "validation.png"):
        assert drawn(tmp_path / name)
    assert (tmp_path / "four_bar.sdf").exists()
