"""A log of every machine of the rig that has a shape is replayed: rods hold, ghosts stand where the models are."""

from types import SimpleNamespace

import numpy as np
import pytest

from gapscope.analysis.errors import InputError
from gapscope.analysis.gap.logset import load_logset
from gapscope.analysis.gap.machines import read_machine
from gapscope.analysis.view.replay import replay

MOTIONS = {"mm3a": ("joint 3", 0.004), "arm": ("fold", 0.2)}
CHAINS = ("5r", "replalink", "2prr", "mast", "3prs")


class Sound:
    """A hypothesis that changes nothing, with the own parameters off by a share."""

    def __init__(self, share):
        self.share = share

    def plant(self, machine, values, start):
        off = {name: value * (1.0 + self.share) for name, value in values.items()}
        return machine.build(off).finished()


def judged(log):
    """Of a diagnosis, what a replay asks of it."""
    machine, runs = read_machine(log)
    fits = [
        SimpleNamespace(hypothesis=Sound(share), by_key=machine.nominal) for share in (0.0, 0.02)
    ]
    return SimpleNamespace(
        logset=log, machine=machine, runs=tuple(runs), nominal=fits[0], chosen=fits[1]
    )


def logged(bench, name):
    b = bench(name)
    b.home()
    b.ask("control")
    layout = b.rig.machine.layout
    motion, rate = MOTIONS.get(name, (b.rig.machine.programs[0], layout.rate))
    cycles = 2 if name == "arm" else 1
    b.record(motion, rate=rate, cycles=cycles)
    return load_logset(b.rig.recorder.summary()["folder"])


def own_model():
    from importlib.resources import files

    return str(files("gapscope.models") / "two_joint_arm.sdf")


@pytest.mark.parametrize(
    "name",
    ["own", "pendulum", "arm", "furuta", "mm3a",
     *(pytest.param(n, marks=pytest.mark.slow) for n in ("c-drive", "slider", "pmc", *CHAINS))],
)  # fmt: skip
def test_a_log_of_any_machine_with_a_shape_is_replayed(bench, name):
    found = replay(judged(logged(bench, own_model() if name == "own" else name)))
    assert set(found.ghosts) == {"nominal", "diagnosed"}
    assert found.moves == (name == "mm3a")
    machine = found.machine
    first = machine.place(found.measured[0])
    for k in np.linspace(0, len(found.measured) - 1, 20, dtype=int):
        placed = machine.place(found.measured[k])
        assert set(placed) == {*machine.rods, *machine.balls}
        for rod in machine.rods:
            length = np.linalg.norm(placed[rod][1] - placed[rod][0])
            assert length == pytest.approx(np.linalg.norm(first[rod][1] - first[rod][0]), abs=1e-9)
    half = len(found.measured) // 2  # beyond where the start is still felt
    away = {ghost: (path - found.measured)[half:] for ghost, path in found.ghosts.items()}
    off = {ghost: np.sqrt(np.mean(difference**2)) for ghost, difference in away.items()}
    assert off["nominal"] < off["diagnosed"]  # the log is the nominal model's own
    assert off["diagnosed"] < 0.1 * np.ptp(found.measured, axis=0).max()


def test_what_has_no_shape_says_so(bench):
    log = logged(bench, "piezo")
    with pytest.raises(InputError, match="no shape"):
        replay(judged(log))


def test_the_model_files_skeleton_ends_where_drake_puts_the_bodies():
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    from gapscope.analysis.view.skeletons import skeleton

    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(own_model())
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q = np.array([0.4, -0.7])
    plant.SetPositions(context, q)
    placed = skeleton(own_model()).place(q)
    elbow = plant.GetBodyByName("forearm").EvalPoseInWorld(context)
    np.testing.assert_allclose(placed["to forearm"][1], elbow.translation(), atol=1e-12)
    mass_twice = elbow.multiply(np.array([0.22, 0.0, 0.0]))
    np.testing.assert_allclose(placed["end of forearm"][1], mass_twice, atol=1e-12)
