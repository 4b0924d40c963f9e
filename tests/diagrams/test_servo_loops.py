"""Each machine's servo diagram: every scheme follows, alike in the machine's own file, and small enough to read."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from pydrake.systems.analysis import ResetIntegratorFromFlags, Simulator

import gapscope.diagrams
from gapscope.diagrams import mast_loop, replalink_loop, three_prs_loop, two_prr_loop
from gapscope.diagrams.servo_loop import Coupling, Scheme, build
from gapscope.models.parallel.machine import TableMachine
from gapscope.models.parallel.three_prs import THREE_PRS
from gapscope.models.paths import Line

HOME, LOW = mast_loop.HOME, three_prs_loop.HOME
QUICK = {"step": 5e-4, "velocity_period": 1e-3, "position_period": 2e-3}
# Settings, and a path with a speed of 0.1 m/s after 10 ms.
MACHINES = {
    "2prr": (two_prr_loop.TwoPRRLoop(**QUICK), (0.6, -0.55), (0.62, -0.55)),
    "replalink": (replalink_loop.RePlaLinkLoop(), (0.1, 0.85), (0.12, 0.85)),
    "mast": (mast_loop.MastLoop(**QUICK), (HOME, 0.0, 0.0), (HOME + 0.02, 0.0, 0.0)),
    "3prs": (
        three_prs_loop.ThreePRSLoop(machine=TableMachine(table=THREE_PRS), **QUICK),
        (LOW, 0.0, 0.0),
        (LOW + 0.02, 0.0, 0.0),
    ),
}


def error(loop, path, seconds):
    """Error of the task coordinates at the end of a short run."""
    diagram = build(loop, path)
    simulator = Simulator(diagram)
    ResetIntegratorFromFlags(simulator, "runge_kutta2", loop.step)
    simulator.AdvanceTo(seconds)
    context = simulator.get_context()
    read = lambda name: np.array(diagram.GetOutputPort(name).Eval(context))  # noqa: E731
    return read("position") - read("reference")


@pytest.mark.parametrize("scheme", list(Scheme))
@pytest.mark.parametrize("name", list(MACHINES))
def test_every_scheme_follows_the_path(name, scheme):
    """50 ms at v = 0.1 m/s: computed torque is within 0.1 mm, the cascades lag by about v / k_v = 2.5 mm."""
    loop, start, end = MACHINES[name]
    path = Line(start=start, end=end, feed=0.1, acceleration=10.0)
    off = np.linalg.norm(error(replace(loop, scheme=scheme, position_gain=40.0), path, 0.05))
    if scheme in (Scheme.torque, Scheme.torque_workspace):
        assert off < 1e-4
    else:
        assert off == pytest.approx(2.5e-3, rel=0.35)


def test_defaults_are_a_disturbance_where_the_machine_is_lighter_than_its_axes():
    for name, (loop, start, _) in MACHINES.items():
        q = loop.machine.inverse(np.array(start))
        inertia = loop.machine.equations(q, 0.0 * q).inertia
        lighter = np.linalg.eigvalsh(inertia)[-1] < loop.axis.joint_inertia
        assert (loop.coupling == Coupling.disturbance) == lighter, name


def test_files_are_short_enough_to_read():
    for file in Path(gapscope.diagrams.__file__).parent.glob("*_loop.py"):
        assert len(file.read_text().splitlines()) < 150, file.name
