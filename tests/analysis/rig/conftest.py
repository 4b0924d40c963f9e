"""A rig without a clock: as many samples as are asked for, at once."""

import pytest

from gapscope.analysis.rig import machines
from gapscope.analysis.rig.controller import Rig
from gapscope.analysis.rig.recorder import Recorder
from gapscope.analysis.rig.states import MOVING, Event, State


class Bench:
    """Drives a rig through whole motions."""

    def __init__(self, kind, folder, fault="none", seed=1, **model):
        self.rig = Rig(machines.build(kind, fault, seed, **model), Recorder(folder), seed)
        self.tick(1)

    def tick(self, samples):
        for _ in range(samples):
            self.rig.tick()

    def ask(self, event, **data):
        self.rig.request(Event(event), data)

    def until_standing(self, limit=60_000):
        for _ in range(limit):
            if self.rig.standing and self.rig.state not in MOVING:
                return
            self.rig.tick()
        raise AssertionError(f"still {self.rig.state} after {limit} samples")

    def home(self):
        self.ask("home")
        self.ask("start")
        self.until_standing()
        assert self.rig.state is State.HOME
        self.ask("close")

    def record(self, name, rate=2.0, cycles=3, use="fit"):
        self.ask("load", name=name, rate_Hz=rate, cycles=cycles)
        self.ask("start", use=use)
        self.until_standing()
        assert self.rig.state is State.LOADED, self.rig.message

    def axes(self):
        return self.rig.machine.layout.axis(self.rig.machine.read())


@pytest.fixture
def bench(tmp_path):
    return lambda kind="c-drive", **options: Bench(kind, tmp_path / "rig", **options)
